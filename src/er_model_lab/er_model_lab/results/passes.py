"""What the passes of `improve` found, told as one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from er_model_lab.diagnosis.evidence import leaves_more_than_noise, shares
from er_model_lab.diagnosis.floor_estimates import AGREE
from er_model_lab.diagnosis.found import Diagnosis
from er_model_lab.diagnosis.rule import RULE, Rule
from er_model_lab.diagnosis.search import MOST_EFFECTS
from er_model_lab.diagnosis.verdict import SETTLED, Earlier, Evidence, decide
from er_model_lab.view import CandidateView

Result = dict[str, Any]
OF_THE_LAST = (
    "rmse_after",
    "noise_floor",
    "noise_floor_train",
    "floors",
    "unexplained",
    "confounded",
    "held_out_beyond",
)
"""What holds of the model that the last pass made."""
BEYOND = "the held-out data go beyond"
"""How the note on the reach of held-out data begins."""
OF_RECORDS, OF_CHANNELS = ("rmse_after", "rmse_left_out"), ("rmse_after", "noise_floor")
"""The same of each record, and of each output of a car."""


def told_together(
    results: Sequence[Result],
    seen: Evidence,
    rule: Rule = RULE,
    dropped: Mapping[str, Sequence[str]] | None = None,
) -> Result:
    """The contract's JSON of all passes: candidates as the first saw them, `spoken_of` by a later one as that did.

    seen: evidence of the last pass; dropped: effects that were taken and are needless beside the others, each
    with what came in its place.
    """
    whole = dict(results[0])
    for more in results[1:]:
        whole["steps"] = whole["steps"] + more["steps"][1:]
        whole["effects"] = _with(whole["effects"], more["effects"])
        whole["alternatives"] = _with(whole["alternatives"], more["alternatives"])
        whole["candidates"] = _candidates(whole["candidates"], more, whole["effects"])
        whole |= {key: more[key] for key in OF_THE_LAST if key in more}
        if not more.get("long"):
            whole["noise_floor"] = min([whole["noise_floor"], *_left_by(whole["candidates"])])
        whole |= left_after(whole, more)
    last, dropped = results[-1], dropped or {}
    whole["final_verdict"] = _final(last)
    whole["effects"] = [e for e in whole["effects"] if e not in dropped]
    whole["alternatives"] = [g for g in whole["alternatives"] if not set(g) & set(dropped)]
    whole["candidates"] = [
        _gone(e, dropped[e["effect"]] or whole["effects"]) if e["effect"] in dropped else e
        for e in whole["candidates"]
    ]
    if len(results) > 1 and results[0]["verdict"] == "partial":
        earlier = Earlier(tied=bool(whole["alternatives"]), too_many=too_many(whole))
        whole["verdict"] = decide(replace(seen, earlier=earlier), rule)
        whole["reasons"] = _with(whole["reasons"], last["reasons"])
    elif results[0]["verdict"] == "missing_effect":
        unsure = [r for r in results[1:] if r["effects"] and r["verdict"] != "missing_effect"]
        # what a later pass names without certainty is not certain in the whole, either
        for more in unsure[:1]:
            whole["verdict"] = more["verdict"]
            whole["reasons"] = _with(whole["reasons"], more["reasons"])
    return whole


def _gone(entry: Result, better: Sequence[str]) -> Result:
    """The entry of an effect that was taken and is needless beside others."""
    return entry | {"status": "absent", "confounded_with": [], "explained_by": list(better)}


def _left_by(candidates: Sequence[Result]) -> list[float]:
    """What models that were tried left of the same held-out data [N]: no noise is louder."""
    stated = (c.get("rmse_held_out") for c in candidates)
    return [float(each) for each in stated if each is not None]


def of_the_last(notes: Sequence[str], last: Sequence[str]) -> list[str]:
    """Notes of the first pass, of which the one on held-out data beyond those learnt from is that of the last."""
    now = next((note for note in last if note.startswith(BEYOND)), None)
    told = [now if note.startswith(BEYOND) else note for note in notes]
    return [note for note in told if note is not None]


def _final(last: Result) -> str:
    """The verdict on the model that was made: with what the last pass took, does it lack anything?"""
    if last["verdict"] not in SETTLED:
        return str(last["verdict"])
    left, noise = last["rmse_after"].get("train"), last.get("noise_floor_train")
    return "adequate" if left is None or noise is None or left <= AGREE * noise else "partial"


def left_after(before: Result, more: Result) -> Result:
    """Errors of each record and of each output before, and of all of long data, with those that a later pass left."""
    out: Result = {}
    if before.get("channels") and more.get("channels"):
        old, new = before["channels"], more["channels"]
        out["channels"] = {k: old[k] | {n: new[k][n] for n in OF_CHANNELS} for k in old}
    if before.get("by_record") and more.get("by_record"):
        left = {each["record"]: {n: each[n] for n in OF_RECORDS} for each in more["by_record"]}
        out["by_record"] = [each | left.get(each["record"], {}) for each in before["by_record"]]
    if before.get("long") and more.get("long"):
        kept = {"before": before["long"]["rmse"]["before"]}
        out["long"] = more["long"] | {"rmse": more["long"]["rmse"] | kept}
    return out


def explained_by(first: Diagnosis, last: Diagnosis) -> dict[str, float]:
    """What the first of several passes left to explain, over the floor of the last, and what all have explained."""
    found = shares(first.base.mse, last.best.mse, last.floor)
    return dict(zip(("explainable", "explained"), found, strict=True))


def too_many(whole: Result) -> bool:
    """Whether so many effects were added that they describe the data and are no cause, as a search says of its own."""
    if len(whole["effects"]) < MOST_EFFECTS:
        return False
    after, floor = whole["rmse_after"]["held_out"], whole["noise_floor"]
    return len(whole["effects"]) > MOST_EFFECTS or leaves_more_than_noise(after**2, floor)


def spoken_of(result: Result) -> set[str]:
    """Effects that a pass took, and those that it cannot tell from them."""
    taken = set(result["effects"])
    return taken.union(*(group for group in result["alternatives"] if taken & set(group)))


def _with(before: list[Any], more: list[Any]) -> list[Any]:
    return before + [each for each in more if each not in before]


def _candidates(before: list[Result], more: Result, order: list[str]) -> list[Result]:
    """Those taken first, in the order in which they were."""
    spoken = spoken_of(more)
    taken = {e["effect"]: e for e in more["candidates"] if e["effect"] in spoken}
    others = [e for e in before if e["effect"] not in taken]
    place = {name: i for i, name in enumerate(order)}
    return sorted([*others, *taken.values()], key=lambda e: place.get(e["effect"], len(place)))


def taken_last(
    cards: Sequence[tuple[CandidateView, ...]], results: Sequence[Result]
) -> tuple[CandidateView, ...]:
    """Evidence cards of the first pass, with those of what a later one took, or is unsure of, as it saw them."""
    later = {
        card.effect: card
        for more, result in zip(cards[1:], results[1:], strict=True)
        for card in more
        if card.effect in spoken_of(result)
    }
    kept = [card for card in cards[0] if card.effect not in later]
    lead = sum(card.effect in results[0]["effects"] for card in kept)
    return (*kept[:lead], *later.values(), *kept[lead:])

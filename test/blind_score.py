"""Scores the lab on the blind generator: ``./er exec python -m test.blind_score --seeds 1 2``.

Prints one row a case and a summary, as Markdown.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

from er_model_lab.commands import Request, diagnose

from test.blind.catalogue import INSIDE, OUTSIDE
from test.blind.generator import make_case

ROOT = Path(__file__).resolve().parents[1]
MODEL = ROOT / "config" / "dampers" / "inove_guo.yaml"


def judged(effect: str | None, result: dict[str, object]) -> str:
    """right, tied (in a group of two), silent (nothing named), or wrong."""
    found, verdict = list(result["effects"]), str(result["verdict"])  # type: ignore[call-overload]
    if effect is None:
        return "right" if verdict == "adequate" else "wrong"
    if effect.startswith("outside:"):
        return (
            "right"
            if verdict in ("unknown_effect", "partial")
            else ("silent" if not found else "wrong")
        )
    if found == [effect]:
        return "right"
    groups = [set(g) for g in result["alternatives"]]  # type: ignore[attr-defined]
    if any(effect in g and len(g) <= 2 for g in groups):
        return "tied"
    return "silent" if not found else "wrong"


def score(effect: str | None, seed: int) -> tuple[str, ...]:
    """One row: what was hidden, what was said."""
    with tempfile.TemporaryDirectory() as folder:
        data = Path(folder) / "data"
        make_case(effect, seed, out=data)
        began = time.monotonic()
        result = diagnose(Request([data], MODEL, seed)).result
        seconds = time.monotonic() - began
        after = result["rmse_after"]["held_out"]
        named = " ".join(result["effects"]) or "-"
        errors = (result["rmse"]["held_out"], after, result["noise_floor"])
    words = (effect or "nothing", str(seed), judged(effect, result), result["verdict"], named)
    return (*words, *(f"{e:.3f}" for e in errors), f"{seconds:.0f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument(
        "--effects", nargs="+", help="names, `none`, `outside:KIND`; by default all"
    )
    given = parser.parse_args()
    effects = given.effects or [*(e.name for e in (*INSIDE, *OUTSIDE)), "none"]
    counts: dict[str, int] = {}
    head = (
        "hidden",
        "seed",
        "judged",
        "verdict",
        "named",
        "before [N]",
        "after [N]",
        "floor [N]",
        "s",
    )
    sys.stdout.write("| " + " | ".join(head) + " |\n|" + "---|" * len(head) + "\n")
    for effect in effects:
        for seed in given.seeds:
            row = score(None if effect == "none" else effect, seed)
            counts[row[2]] = counts.get(row[2], 0) + 1
            sys.stdout.write("| " + " | ".join(row) + " |\n")
            sys.stdout.flush()
    total = sum(counts.values())
    summary = ", ".join(f"{k} {v}" for k, v in sorted(counts.items()))
    sys.stdout.write(f"\n{total} cases: {summary}\n")


if __name__ == "__main__":
    main()

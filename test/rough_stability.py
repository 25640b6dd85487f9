"""Whether verdicts hang on what says nothing: ``./er exec python -m test.rough_stability --seeds 1 --cases 30``.

Each rough case is asked again with what must not matter: data times 1 + 1e-10, records in another order, ten samples
cut at the start, another seed. The same verdict and names must come out, or names tied with these, and values within a
standard deviation. Rows are noted as `test.rough_score` notes its own.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from er_model_lab.verbs.load import load
from er_records.dataset import Dataset
from er_records.record import Record
from er_studies.given_out import table

from test.blind_score.answer import timed
from test.blind_score.program import collect, finish, heading, parser_of, seeds_of
from test.blind_score.rows import digest
from test.blind_score.tables import wilson
from test.rough.case import RoughError, make_case
from test.rough.plan import KINDS, Asked, plan
from test.rough_score.__main__ import DECIDES
from test.rough_score.run import LIMIT, improved

Row = Mapping[str, Any]
NINTH_DIGIT = 1e-10
"""Share by which every channel is changed."""
CUT = 10
"""Samples that a record loses at its start."""
FAR = 1.0
"""Standard deviations that a value may move."""


def scaled(record: Record) -> Record:
    """Every channel but the duty times 1 + 1e-10; the time as it is."""
    more = {k: y if k == "duty" else y * (1.0 + NINTH_DIGIT) for k, y in record.channels.items()}
    return replace(record, channels=more)


CHANGES: dict[str, Callable[[Dataset], Dataset]] = {
    "as it is": lambda data: data,
    "1 + 1e-10": lambda data: data.mapped(scaled),
    "order": lambda data: Dataset.of(reversed(data.learn)),
    "cut": lambda data: data.mapped(lambda record: record.slice(CUT, None)),
    "seed": lambda data: data,
}
"""What is done to the data; only `seed` is asked with another one."""


def asked_again(asked: Asked, *, changes: Sequence[str], limit: float = LIMIT) -> dict[str, Any]:
    """One row: what is answered to a case as it is, and to each change of it."""
    row: dict[str, Any] = {"key": asked.key, "kind": asked.kind, "seed": asked.seed}
    with tempfile.TemporaryDirectory() as place:
        try:
            case = make_case(asked, Path(place) / "case")
        except RoughError as error:
            return row | {"unmade": str(error)}
        data, answers = load(case.data), {}
        for change in ("as it is", *changes):
            if change == "order" and len(data.learn) < 2:
                continue
            changed, seed = CHANGES[change](data), asked.seed + (change == "seed")
            answers[change] = timed(partial(_said, changed, case.folder, seed, limit))
        return row | {"changes": list(changes), "answers": answers}


def _said(data: Dataset, folder: Path, seed: int, limit: float) -> dict[str, Any]:
    """What the lab says of data, or that it took too long."""
    found = improved(data, folder, seed, limit)
    if found is None:
        return {"failed": f"no answer within {limit:g} s of processor time"}
    result, model = found.to_dict(), found.model
    values = {} if model is None else {e: dict(model.effects[e]) for e in result["effects"]}
    deviations = {} if model is None else model.deviations
    return {
        "verdict": result["verdict"], "names": result["effects"], "alternatives": result["alternatives"],
        "values": {
            e: {q: [value, deviations.get(e, {}).get(q, np.inf)] for q, value in own.items()}
            for e, own in values.items()
        },
        "rmse": result["rmse_after"],
    }  # fmt: skip


def differences(first: Row, other: Row) -> list[str]:
    """What differs between two answers: verdict, names that no tie excuses, values by deviations."""
    if first.get("failed") or other.get("failed"):
        same = first.get("failed") == other.get("failed")
        return [] if same else [f"failed: {first.get('failed') or other.get('failed')}"]
    out = []
    if first["verdict"] != other["verdict"]:
        out.append(f"{first['verdict']}, then {other['verdict']}")
    ties = [set(g) for g in (*first["alternatives"], *other["alternatives"])]
    for here, there in ((first, other), (other, first)):
        lone = [n for n in here["names"] if n not in there["names"]]
        out += [n for n in lone if not any(n in tie and tie & {*there["names"]} for tie in ties)]
    return out + [
        f"{name}.{q} {abs(value - moved) / sd:.1f} sd"
        for name in set(first["values"]) & set(other["values"])
        for q, (value, sd) in first["values"][name].items()
        for moved in [other["values"][name][q][0]]
        if abs(value - moved) > FAR * sd
    ]


def page(rows: Sequence[Row], title: str) -> str:
    """Shares of cases whose answer stays, by change, and every one that does not."""
    made = [row for row in rows if "answers" in row]
    told = [
        (row["key"], change, differences(row["answers"]["as it is"], answer))
        for row in made
        for change, answer in row["answers"].items()
        if change != "as it is"
    ]
    lines = []
    for change in [c for c in CHANGES if any(c == t[1] for t in told)]:
        own = [found for _, c, found in told if c == change]
        same = sum(not found for found in own)
        low, high = wilson(same, len(own))
        lines.append([change, f"{same}/{len(own)}", f"{low:.1%} to {high:.1%}"])
    missed = [[key, change, "; ".join(found)] for key, change, found in told if found]
    shares = table(["change", "the same", "95 % interval"], lines)
    what = table(["case", "change", "differs"], missed) if missed else "Nothing differs.\n"
    return f"{title}\n\n{shares}\n{what}"


def main(argv: list[str] | None = None) -> int:
    """Command line."""
    parser = parser_of("rough_stability", __doc__)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=list(KINDS))
    parser.add_argument("--cases", type=int, help="only the first so many of each seed")
    parser.add_argument("--match", default="", help="only cases whose key holds this text")
    parser.add_argument("--limit", type=float, default=LIMIT, help="processor time [s] an answer")
    able = [c for c in CHANGES if c != "as it is"]
    parser.add_argument("--changes", nargs="+", choices=able, default=able)
    given = parser.parse_args(argv)

    def make() -> str:
        asked = {
            a.key: a for a in plan(given.kinds, seeds_of(given.seeds), given.cases, given.match)
        }
        one = partial(asked_again, changes=tuple(given.changes), limit=given.limit)

        def fits(row: dict[str, Any]) -> bool:
            return bool(row.get("changes") == given.changes)

        rows = collect(given, asked, one, fits, digest(folders=DECIDES))
        return page(rows, heading(given, rows))

    return finish(given, make)


if __name__ == "__main__":
    raise SystemExit(main())

"""Do the intervals hold what they promise? ``./er exec python -m test.blind_score.cover --seeds 1-20``.

Mode `simulated`: truths by the lab's own equations (`lab_truth.py`), noise of every sensor, the effect added by
`lab add` with everything refitted; every fitted parameter of the effect has a true value. Mode `blind`
(``--blind FILE``): rows of the blind score whose parameter means the same in generator and lab.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from er_model_lab.verbs.add import add
from er_model_lab.verbs.load import load
from er_models.catalogue import CATALOGUE
from er_models.errors import InputError
from er_models.files import load_model

from test.blind_score.answer import guarded
from test.blind_score.judge import judged
from test.blind_score.lab_truth import draw_truth, write_noisy
from test.blind_score.program import Rows, collect, finish, heading, parser_of, seeds_of
from test.blind_score.rows import read
from test.blind_score.run import MODEL
from test.blind_score.summary import table, wilson

Z = 1.959964
RECORDS, SECONDS = 3, 25.0
NAMES = tuple(e.name for e in CATALOGUE.candidates())
SHARED = {
    ("dead_time", "T_d"): "T_d",
    ("preload", "F_0"): "F_0",
    ("fluid_inertia", "m_f"): "m",
    ("force_delay", "d"): "d",
    ("force_lag", "T_f"): "T",
    ("deflection_zero", "x_0"): "x_0",
    ("coulomb_friction", "F_c"): "F_c",
}
"""Parameters of the lab that mean the same in the generator, and their symbols there."""
REFERRED = {("herschel_bulkley", "c_h")}
"""Parameters that mean a force at a reference which the lab takes from the data: another one than the truth's."""


class Estimate(NamedTuple):
    """One fitted parameter and its true value; sd None where the fit says that it is undetermined."""

    effect: str
    parameter: str
    truth: float
    value: float
    sd: float | None

    @property
    def z(self) -> float:
        """Error in standard deviations."""
        return (self.value - self.truth) / (self.sd or float("inf"))


def score(job: tuple[str, int]) -> dict[str, Any]:
    """One row: truth and estimate of every fitted parameter of an effect."""
    name, seed = job
    row: dict[str, Any] = {"key": f"cover/{name}/{seed}", "effect": name, "seed": seed}
    return row | guarded(partial(_estimates, name, seed))


def _estimates(name: str, seed: int) -> dict[str, Any]:
    """The truth and what `add` finds."""
    truth = draw_truth(name, seed, RECORDS, SECONDS)
    with tempfile.TemporaryDirectory() as place:
        data = write_noisy(truth, seed, Path(place) / "data")
        result = add(load(data), load_model(MODEL), name, seed=seed).to_dict()
    found = next(c for c in result["candidates"] if c["effect"] == name)["parameters"]
    fitted = {
        q.name for q in CATALOGUE[name].parameters if q.fitted and (name, q.name) not in REFERRED
    }
    return {
        "rise": truth.rise,
        "verdict": result["verdict"],
        "parameters": {
            q: [truth.model.value(name, q), *found[q][:2]] for q in found if q in fitted
        },
    }


def simulated(rows: Rows) -> list[Estimate]:
    """Estimates of the rows that gave an answer."""
    return [
        Estimate(r["effect"], q, *values)
        for r in rows
        for q, values in r.get("parameters", {}).items()
    ]


def blind(rows: Iterable[dict[str, Any]]) -> list[Estimate]:
    """Estimates of rightly named single effects whose parameter the generator shares."""
    found = []
    for r in rows:
        if r["kind"] == "singles" and judged(r) == "first":
            (effect,) = r["hidden"]
            for q, (value, sd, _) in r["parameters"].get(effect, {}).items():
                if (effect, q) in SHARED:
                    truth = r["truth"][effect][SHARED[effect, q]]["value"]
                    found.append(Estimate(effect, q, truth, value, sd))
    return found


def line(label: str, part: Sequence[Estimate]) -> list[str]:
    """Coverage of some estimates."""
    known = [e for e in part if e.sd]
    hits = sum(abs(e.z) <= Z for e in known)
    low, high = wilson(hits, len(known))
    z = [e.z for e in known]
    return [
        label,
        f"{hits}/{len(known)}",
        f"{hits / max(len(known), 1):.1%}",
        f"{low:.1%} to {high:.1%}",
        f"{np.mean(z):+.2f}" if z else "-",
        f"{np.std(z):.2f}" if z else "-",
        str(len(part) - len(known)),
    ]


def coverage(title: str, estimates: Sequence[Estimate]) -> str:
    """Coverage of all estimates together and of every parameter, as Markdown."""
    groups: dict[str, list[Estimate]] = {}
    for e in estimates:
        groups.setdefault(f"{e.effect} {e.parameter}", []).append(e)
    lines = [line("all", estimates), *(line(k, g) for k, g in sorted(groups.items()))]
    head = [
        "parameter",
        "covered",
        "share",
        "95 % interval",
        "mean z",
        "spread of z",
        "undetermined",
    ]
    return f"## {title}\n\n{table(head, lines)}\n"


def arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = parser_of("cover", __doc__)
    parser.add_argument("--effects", nargs="+", help="by default all candidates of the catalogue")
    parser.add_argument("--blind", type=Path, help="results file of the blind score to read too")
    return parser.parse_args(argv)


def main(argv: list[str] | None = None) -> int:
    """Command line."""
    given = arguments(argv)

    def make() -> str:
        for name in given.effects or []:
            if name not in NAMES:
                raise InputError("--effects", "", "a candidate of the catalogue", name)
        seeds = seeds_of(given.seeds)
        jobs = {f"cover/{e}/{s}": (e, s) for s in seeds for e in given.effects or NAMES}
        rows = collect(given, jobs, score)
        failed = [f"- {r['key']}: {r['failed']}" for r in rows if "failed" in r]
        text = f"{heading(given, rows)}\n\n" + coverage(
            "Truth by the lab's equations", simulated(rows)
        )
        if given.blind:
            text += coverage("Truth by the blind generator", blind(read(given.blind)))
        return text + ("## Without an answer\n\n" + "\n".join(failed) + "\n" if failed else "")

    return finish(given, make)


if __name__ == "__main__":
    raise SystemExit(main())

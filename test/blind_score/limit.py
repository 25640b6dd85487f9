"""What nobody can promise on fresh data: ``./er exec python -m test.blind_score.limit --seeds 58 63``.

A record shows a law only as far as it was driven. For a case of the score another damper is made, whose law has
another form and whose values are refitted until its force along the motion of the record is as near to that of the
hidden one as it can be: d, in standard deviations of the force noise over all samples. Whoever is given the force,
and be it with the motion exactly known, then takes one for the other with a probability of at least Phi(-d / 2)
(Neyman and Pearson), whatever is computed from it. Along the motion of a fresh record the two forces are D apart (root
mean square), so that a model made from the first record is wrong by at least D / 2 for one of the two (the triangle
inequality), beside what the sensors of the fresh record do to the truth itself.
"""

from __future__ import annotations

import math
import tempfile
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from er_models.files import load_model
from scipy.optimize import least_squares

from test.blind.along import imposed
from test.blind.calibrate import clean_records
from test.blind.case import Case
from test.blind.generator import more_records
from test.blind.jit import Array
from test.blind_score.answer import guarded
from test.blind_score.cases import Asked, Layout
from test.blind_score.fresh import fresh_errors
from test.blind_score.fused import rms
from test.blind_score.program import Rows, collect, finish, heading, parser_of, seeds_of
from test.blind_score.run import ANOTHER, MODEL, drawn
from test.blind_score.summary import WORST_RATIO, table

BENT = 6
"""Column of the effect table that holds the form of the yield force, less one."""
FORMS = {"exponential": -1.0, "line": -2.0}
"""Other forms of the yield force over the temperature; what is drawn is a hyperbola."""
TRIALS, FARTHEST = 12, 1.0
"""Steps of the refit, and how far it may take the logarithm of a value."""


@dataclass(frozen=True)
class Rival:
    """Another damper whose force on the records is nearly that of a case.

    Attributes:
        case: the case with the other damper in place of the hidden one.
        distance: d, of all samples of what is seen, in standard deviations of its noise.
    """

    case: Case
    distance: float

    @property
    def mistaken(self) -> float:
        """Probability that the best test takes one for the other, at equal rates."""
        return 0.5 * math.erfc(0.5 * self.distance / math.sqrt(2.0))


def true_motion(case: Case) -> Case:
    """The case on a rig that imposes the motion that its car has."""
    motions = []
    for record, clean in enumerate(case.clean):
        relative = clean["sprung_acceleration"] - clean["unsprung_acceleration"]
        motion = np.stack([clean["deflection"], clean["deflection_velocity"], relative], axis=1)
        motions.append(imposed(case, record, motion))
    return replace(case, rig="damper", motions=tuple(motions))


def forces(damper: Case, rig: Case) -> Array:
    """Noiseless force [N] of a case's damper on a rig, all records end to end."""
    records = clean_records(rig.motions, damper.table, damper.base, rig.seconds)
    return np.concatenate([r["damper_force"] for r in records])


def rival(case: Case, bend: float, *, car: bool = False) -> Rival:
    """The damper of another form that comes nearest, by least squares in logarithms of its values.

    car: whether all channels of the car on its road are seen, else the force along the motion alone.
    """
    (one,) = case.hidden
    used, split = one.row != 0.0, case.base.size
    start, noise = np.concatenate([case.base, one.row[used]]), case.noise
    rig, sizes = case if car else true_motion(case), {"damper_force": noise.force}
    if car:
        sizes |= {"deflection": noise.deflection, "deflection_velocity": noise.velocity}
        sizes |= dict.fromkeys(
            ("sprung_acceleration", "unsprung_acceleration"), noise.acceleration
        )

    def seen(damper: Case) -> Array:
        records = clean_records(rig.motions, damper.table, damper.base, rig.seconds)
        return np.concatenate([r[name] / size for r in records for name, size in sizes.items()])

    def another(shift: Array) -> Case:
        values, row = start * np.exp(shift), one.row.copy()
        row[used], row[BENT] = values[split:], bend
        return replace(case, base=values[:split], hidden=(replace(one, row=row),))

    truth = seen(case)
    best = least_squares(
        lambda shift: seen(another(shift)) - truth,
        np.zeros(start.size),
        bounds=(-FARTHEST, FARTHEST),
        diff_step=1e-4,
        max_nfev=TRIALS,
    )
    return Rival(another(best.x), math.sqrt(2.0 * best.cost))


def score(seed: int, seconds: float, car: bool) -> dict[str, Any]:
    """One row: the nearest damper of each other form, and how far apart fresh forces are."""
    row = {"key": f"limit/{seed}", "seed": seed, "seconds": seconds, "car": car}
    return row | guarded(partial(_limits, seed, seconds, car))


def _limits(seed: int, seconds: float, car: bool) -> dict[str, Any]:
    """The case as the score draws it, and its fresh record."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        case, _ = drawn(Asked("singles", ("self_heating",), seed), Layout(1, seconds), folder)
        fresh = more_records(case, case.seed + ANOTHER // 2, out=folder / "fresh", n_records=1)
        truth = float(fresh_errors(fresh, load_model(MODEL))["truth"])
    rig, found = true_motion(fresh), {}
    here = forces(case, rig)
    for name, bend in FORMS.items():
        other = rival(case, bend, car=car)
        gap = rms(forces(other.case, rig) - here)
        found[name] = {
            "distance": other.distance,
            "mistaken": other.mistaken,
            "gap": gap,
            "ratio": math.hypot(truth, 0.5 * gap) / truth,
        }
    return {"truth": truth, "forms": found}


def page(rows: Rows, head: str) -> str:
    """The result as Markdown."""
    words = [
        *("seed", "other form", "d of the record", "taken for the other"),
        *("D on fresh data, N", "truth's error there, N", "least ratio for one of the two"),
    ]
    lines = [
        [
            str(r["seed"]),
            name,
            f"{f['distance']:.2f}",
            f"{f['mistaken']:.0%}",
            f"{f['gap']:.2f}",
            f"{r['truth']:.3f}",
            f"{f['ratio']:.2f}",
        ]
        for r in rows
        for name, f in r["forms"].items()
    ]
    over = sum(any(f["ratio"] > WORST_RATIO for f in r["forms"].values()) for r in rows)
    return (
        f"{head}\n\n{table(words, lines)}\nBeyond {WORST_RATIO:.2f} for one of two dampers, whatever is done: "
        f"{over} of {len(rows)}.\n"
    )


def main(argv: list[str] | None = None) -> int:
    """Command line."""
    parser = parser_of("limit", __doc__)
    parser.add_argument("--seconds", type=float, default=60.0, help="length of a record")
    parser.add_argument("--car", action="store_true", help="all channels, road and car known")
    given = parser.parse_args(argv)

    def fits(row: dict[str, Any]) -> bool:
        return (row["seconds"], row["car"]) == (given.seconds, given.car)

    def make() -> str:
        jobs = {f"limit/{s}": s for s in seeds_of(given.seeds)}
        rows = collect(given, jobs, partial(score, seconds=given.seconds, car=given.car), fits)
        rows = [r for r in rows if "failed" not in r]
        return page(rows, heading(given, rows))

    return finish(given, make)


if __name__ == "__main__":
    raise SystemExit(main())

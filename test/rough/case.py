"""A case: a device with its hidden truth, strong enough to show, and its measurements.

The strength is set so that the part of the force which no value of the start model can take up (the rest of a linear
fit of its parameters) is a drawn multiple of what the true model leaves: noise of the force and errors of the motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import BPoly

from test.rough import sensors
from test.rough.device import (
    BASE,
    BETA,
    C1,
    FC,
    FY,
    K1,
    LAWS,
    TAU,
    V0,
    ZERO,
    Array,
    run,
)
from test.rough.drives import MOTIONS, POOR, Drive, draw_drive
from test.rough.names import BESIDE, RIGHT
from test.rough.plan import SIZES, Asked
from test.rough.rig import DRIVEN, Rig, draw_rig, log_uniform
from test.rough.sensors import Columns, Wrong
from test.rough.truths import TRUTHS, Rows, Truth, scale_of, stronger, table
from test.rough.write import start_values, write_model, write_record, write_truth

TRIALS = 8
LEAST, CLEAR_TWIN = 0.5, 3.0
"""Rest that an effect leaves at least, over what the true model leaves; a twin's, where it is plausible."""
NATURAL = 0.3
"""Share of the singles whose strength is left as it was drawn, where that shows."""


class RoughError(Exception):
    """A case that cannot be made; one line."""


@dataclass(frozen=True)
class Case:
    """Measurements with their truth.

    Attributes:
        asked: which case it is.
        rig: device and bench.
        laws: table of the hidden laws (36, 5).
        shown: rest of each hidden effect alone, over what the true model leaves.
        drives: of the training records, and last of the fresh one.
        wrong: what goes wrong in each of them.
        clean, noisy: columns of each.
        folder: holds `data`, `fresh`, `model.yaml` and `sealed`.
    """

    asked: Asked
    rig: Rig
    laws: Array
    shown: tuple[float, ...]
    drives: tuple[Drive, ...]
    wrong: tuple[Wrong, ...]
    clean: tuple[Columns, ...]
    noisy: tuple[Columns, ...]
    folder: Path

    @property
    def data(self) -> Path:
        """Folder of the training records."""
        return self.folder / "data"

    @property
    def fresh(self) -> Path:
        """Folder of the record that nobody learns from."""
        return self.folder / "fresh"

    @property
    def right(self) -> tuple[tuple[str, ...], ...]:
        """For each hidden effect the names that are right."""
        return tuple(RIGHT[name] for name in self.asked.truths)

    @property
    def beside(self) -> tuple[str, ...]:
        """Names that are not wrong, either."""
        return tuple(n for name in self.asked.truths for n in BESIDE.get(name, ()))


def simulated(rig: Rig, drive: Drive, laws: Array, base: Array | None = None) -> Array:
    """Force of the device on the fine grid (n,) [N]."""
    base = rig.base if base is None else base
    return np.asarray(
        run(drive.x, drive.v, drive.a, drive.u, 1.0 / rig.fine, drive.lead, base, laws)
    )


def _moved(drive: Drive, zero: float) -> Drive:
    """The drive as a deflection sensor with an error of its zero shows it."""
    return Drive(
        drive.x + zero, drive.v, drive.a, drive.u, drive.lead, drive.motion, drive.duty, drive.rest
    )


def free(rig: Rig) -> list[int]:
    """Which values of the base the start model holds."""
    out = [0, 1]
    if rig.device in DRIVEN:
        out += [FY, TAU, BETA] if rig.device == "mr" else [FY, K1, C1, TAU]
    return out + ([FC, V0] if rig.device == "brake" else [])


def rest_of(rig: Rig, drive: Drive, laws: Array) -> float:
    """Root mean square [N] of what the hidden laws add beyond any small change of the base's values."""
    seen, none = _moved(drive, laws[ZERO, 0]), np.zeros_like(laws)
    plain = simulated(rig, seen, none)
    columns = []
    for k in free(rig):
        base = rig.base.copy()
        step = 0.01 * abs(base[k]) or 1e-3 / rig.stroke
        base[k] += step
        columns.append(sensors.sampled(rig, drive, simulated(rig, seen, none, base) - plain))
    true = sensors.channel_force(simulated(rig, drive, laws), laws, 1.0 / rig.fine)
    gap = sensors.sampled(rig, drive, true - plain)
    j = np.stack(columns, axis=1)
    j /= np.maximum(np.linalg.norm(j, axis=0), 1e-300)
    return float(np.sqrt(np.mean((gap - j @ np.linalg.lstsq(j, gap, rcond=None)[0]) ** 2)))


def along(rig: Rig, laws: Array, drive: Drive, t: Array, motion: Array) -> Array:
    """The true device's force channel [N] along a motion as it was measured, at the times of that motion (n,).

    t: from the record's begin on [s]; motion: deflection [m], velocity, acceleration (n, 3), with the error of the
    deflection's zero, which the truth knows and takes off. Before it the motion is the true one.
    """
    knots = motion.copy()
    knots[:, 0] -= laws[ZERO, 0]
    fine = (np.arange(drive.x.size) - drive.lead) / rig.fine
    inside = (fine >= t[0]) & (fine <= t[-1])
    curve = BPoly.from_derivatives(t, knots)
    x, v, a = drive.x.copy(), drive.v.copy(), drive.a.copy()
    for order, y in enumerate((x, v, a)):
        y[inside] = curve(fine[inside], nu=order)
    seen = Drive(x, v, a, drive.u, drive.lead, drive.motion, drive.duty, drive.rest)
    force = sensors.channel_force(simulated(rig, seen, laws), laws, 1.0 / rig.fine)
    return np.asarray(np.interp(t, fine, force))


def left(rig: Rig, drive: Drive, laws: Array, clean: Columns, noisy: Columns) -> float:
    """What the true device leaves [N] of a record, driven by a motion that a careful user filters."""
    edge = round(0.5 * rig.rate)
    force = along(rig, laws, drive, clean["t"], sensors.filtered(rig, noisy))
    return float(
        np.sqrt(
            np.mean((force - clean["damper_force"])[edge:-edge] ** 2)
            + rig.noise[sensors.FORCE] ** 2
        )
    )


def _drives(asked: Asked, rig: Rig, rng: np.random.Generator) -> tuple[Drive, ...]:
    """Training drives and a fresh one within what they reach; of different kinds where none is given."""
    like = asked.like
    poor = asked.kind == "poor" or like.motion in POOR
    rest = like.rest or (not asked.twin and rng.random() < 0.35)
    kinds = [str(k) for k in rng.permutation(list(MOTIONS))]
    first = like.motion or (str(rng.choice(list(POOR))) if poor else kinds[0])
    motions = [first, *(first if poor or like.motion else k for k in kinds[1 : rig.records])]
    duties = [
        "level" if poor else str(rng.choice(["steps", "steps", "switched", "wander"]))
        for _ in motions
    ]
    out = [draw_drive(rig, rng, m, u, rest=rest) for m, u in zip(motions, duties, strict=True)]
    other = like.motion if like.motion and not poor else kinds[-1]
    return (*out, draw_drive(rig, rng, other, "steps", rest=rest, within=out))


def _wrong(asked: Asked, rng: np.random.Generator, count: int) -> tuple[Wrong, ...]:
    """What goes wrong in each record: the bench bends all ends or none, one training record holds wild samples."""
    like, draw = asked.like, rng.random(2)
    bent = like.bent or bool(not asked.twin and draw[0] < 0.15)
    wild = like.wild or (
        "" if asked.twin or draw[1] > 0.2 else str(rng.choice(["outliers", "spike", "clip"]))
    )
    share = 0.002 if asked.twin else rng.uniform(0.002, 0.005)
    return (Wrong(bent, wild, share), *(Wrong(bent) for _ in range(count)))


def _strength(
    truth: Truth, rows: Rows, target: float, rig: Rig, drive: Drive, noise: float
) -> tuple[Rows, float]:
    """The rows at the strength at which they leave a target, and what they leave; as they were drawn without one."""
    found = rest_of(rig, drive, table(rows)) / noise
    for _ in range(5):
        if not target or abs(np.log(max(found, 1e-9) / target)) < 0.1:
            break
        weaker = stronger(truth, rows, float(np.clip(target / max(found, 1e-9), 0.02, 20.0)))
        if weaker == rows:
            break
        rows, found = weaker, rest_of(rig, drive, table(weaker)) / noise
    return rows, found


def _target(asked: Asked, rng: np.random.Generator) -> float:
    """The rest that is asked for, 0 for a strength as it was drawn."""
    drawn = log_uniform(rng, 0.7, 5.0) if asked.kind != "pair" else log_uniform(rng, 1.2, 5.0)
    natural = bool(asked.twin) or (asked.kind == "single" and rng.random() < NATURAL)
    return asked.like.target or (0.0 if natural else drawn)


def _hidden(
    asked: Asked, rig: Rig, drive: Drive, rng: np.random.Generator, noise: float
) -> tuple[Array, tuple[float, ...]] | None:
    """The table of laws with all that is hidden, and what each shows; None where one hardly shows."""
    rows: Rows = {}
    shown = []
    for name in asked.truths:
        truth, target = TRUTHS[name], _target(asked, rng)
        drawn = truth.draw(rng, scale_of(rig))
        now, rest = _strength(truth, drawn, target, rig, drive, noise)
        clear = CLEAR_TWIN if asked.twin else 1.0
        if rest < clear and not target:
            now, rest = _strength(truth, drawn, 1.2 * clear, rig, drive, noise)
        if rest < LEAST and asked.kind != "poor":
            return None
        shown.append(rest)
        rows |= now
    laws = table(rows)
    if len(shown) > 1 and rest_of(rig, drive, laws) / noise < LEAST:
        return None
    return laws, tuple(shown)


def make_case(asked: Asked, folder: Path) -> Case:
    """The measurements of a case, written to a folder that holds none.

    Raises:
        RoughError: an occupied folder, or what is hidden does not show on any of the rigs drawn.
    """
    if (folder / "data").exists():
        raise RoughError(f"{folder}: expected a folder without a case, found data")
    for trial in range(TRIALS):
        rng = np.random.default_rng([*asked.stream, trial])
        force = log_uniform(rng, *SIZES[asked.size]) if asked.size else 0.0
        rig = draw_rig(
            asked.device, rng, force=force, rate=asked.like.rate, sensors=asked.like.sensors
        )
        drives = _drives(asked, rig, rng)
        wrong = _wrong(asked, rng, len(drives) - 1)
        none = np.zeros((len(LAWS), 5))
        bare = sensors.clean(rig, drives[0], simulated(rig, drives[0], none), none)
        noise = left(rig, drives[0], none, bare, sensors.measured(rig, bare, Wrong(), rng))
        hidden = _hidden(asked, rig, drives[0], rng, noise)
        if hidden is not None:
            return _finished(asked, rig, drives, wrong, *hidden, rng, folder)
    raise RoughError(f"{asked.key}: expected an effect that shows, found none on {TRIALS} rigs")


def _finished(
    asked: Asked, rig: Rig, drives: tuple[Drive, ...], wrong: tuple[Wrong, ...], laws: Array, shown: tuple[float, ...],
    rng: np.random.Generator, folder: Path,
) -> Case:  # fmt: skip
    """The case with its columns, written."""
    clean = tuple(sensors.clean(rig, d, simulated(rig, d, laws), laws) for d in drives)
    noisy = tuple(sensors.measured(rig, c, w, rng) for c, w in zip(clean, wrong, strict=True))
    case = Case(asked, rig, laws, shown, drives, wrong, clean, noisy, folder)
    for k, columns in enumerate(noisy[:-1], 1):
        write_record(case.data / f"record_{k}.csv", columns)
    write_record(case.fresh / "record_1.csv", noisy[-1])
    write_model(folder / "model.yaml", rig, start_values(rig, rng))
    write_truth(folder / "sealed" / "truth.json", truth_of(case))
    return case


def truth_of(case: Case) -> dict[str, Any]:
    """Everything that was hidden, and how it was recorded, as plain data."""
    rig = case.rig
    return {
        "key": case.asked.key, "truths": list(case.asked.truths), "right": [list(r) for r in case.right],
        "beside": list(case.beside), "shown": list(case.shown), "device": rig.device,
        "force": rig.force, "stroke": rig.stroke, "velocity": rig.velocity, "duty": rig.duty, "rate": rig.rate,
        "seconds": rig.seconds, "records": rig.records, "sensors": rig.sensors, "noise": rig.noise.tolist(),
        "count": rig.count, "base": dict(zip(BASE, rig.base.tolist(), strict=True)),
        "laws": {n: r.tolist() for n, r in zip(LAWS, case.laws, strict=True) if r[0] != 0.0},
        "drives": [[d.motion, d.duty, "rest" if d.rest else "moving"] for d in case.drives],
        "wrong": [vars(w) for w in case.wrong],
    }  # fmt: skip

"""Benches other than the nominal one: what each changes of a case, and what may be said of it.

The truth stays that of the case (base, effects, strengths); inputs, sampling, instruments, files or the model that
is given differ. So one case is compared with itself under every condition.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from er_models.files import load_model, save_model
from er_models.model import Model

from test.blind.calibrate import clean_records
from test.blind.case import Case
from test.blind.errors import BlindError
from test.blind.integrate import LEAD_SAMPLES, SAMPLE, STEP, SUBSTEPS
from test.blind.jit import Array
from test.blind.measure import COLUMNS, Noise, instruments, with_noise
from test.blind.plant import NO_EFFECT, Motion, trajectory
from test.blind.roads import half_grid
from test.blind.slots import (
    FORCE_DELAY,
    OAS,
    OAU,
    OF,
    OUT_CROSSTALK,
    OUT_DRIFT,
    OUT_HUM,
    OUT_RESONANCE,
    OV,
    OX,
)
from test.blind_score.cases import Layout

Columns = dict[str, Array]
Random = np.random.Generator
NOMINAL_SIZE, NOMINAL_NOISE = Layout(1, 60.0), Noise()
PEAK_VELOCITY, PEAK_STROKE = 0.12, 0.009
_HELD = 2
"""Samples to whose multiples the duty's steps are moved where sampling is not at 200 Hz: 10 ms, in every grid here."""


def same_inputs(motion: Motion, base: Array, rng: Random) -> Motion:
    """Road and duty of the case."""
    del base, rng
    return motion


def same_columns(columns: Columns, rng: Random) -> Columns:
    """The file as it was measured."""
    del rng
    return columns


def same_model(model: Model, rng: Random) -> Model:
    """The nominal model."""
    del rng
    return model


@dataclass(frozen=True)
class Condition:
    """One bench.

    Attributes:
        what: in words.
        size: records and their length.
        rate: of sampling [Hz].
        noise: of the instruments.
        inputs: changes one record's road and duty.
        file: changes the columns that were measured.
        model: changes the model that is given.
        model_file: its file in config/dampers.
        adds: what the bench itself hides besides.
        another_form: whether the model that is given has another law than the truth: something is missing then.
        told: words that the lab's refusal or a note of its result must hold.
    """

    what: str
    size: Layout = NOMINAL_SIZE
    rate: float = 1.0 / SAMPLE
    noise: Noise = NOMINAL_NOISE
    inputs: Callable[[Motion, Array, Random], Motion] = same_inputs
    file: Callable[[Columns, Random], Columns] = same_columns
    model: Callable[[Model, Random], Model] = same_model
    model_file: str = "inove_guo.yaml"
    adds: tuple[str, ...] = ()
    another_form: bool = False
    told: str = ""


def few_steps(motion: Motion, base: Array, rng: Random) -> Motion:
    """Four duties from 0.05 to 0.3, each held 3 to 8 s: the damper is never without field."""
    del base
    duty, at = np.empty(motion.duty.size), 0
    while at < duty.size:
        hold = round(rng.uniform(3.0, 8.0) / SAMPLE)
        duty[at : at + hold] = rng.choice([0.05, 0.13, 0.21, 0.3])
        at += hold
    return replace(motion, duty=duty)


def slow_sine(motion: Motion, base: Array, rng: Random) -> Motion:
    """Duty of 0 to 0.3 along a sine of 0.1 to 0.3 Hz: no steps."""
    del base
    t = np.arange(motion.duty.size) * SAMPLE
    phase = 2.0 * np.pi * (rng.uniform(0.1, 0.3) * t + rng.uniform())
    return replace(motion, duty=np.round(0.15 * (1.0 - np.cos(phase)), 3))


def narrow_band(motion: Motion, base: Array, rng: Random) -> Motion:
    """A road that makes the car move at 1 to 3 Hz only, by 24 sines."""
    edges = np.linspace(1.0, 3.0, 25)
    f, p = rng.uniform(edges[:-1], edges[1:]), rng.uniform(0.0, 2.0 * np.pi, edges.size - 1)
    t = half_grid(motion.duty.size)
    drive = np.zeros_like(motion.drive)
    drive[:, 0] = np.sum(
        [np.sin(2.0 * np.pi * a * t + b) / a for a, b in zip(f, p, strict=True)], axis=0
    )
    drive[:, 0] *= 0.5 * (1.0 - np.cos(np.pi * np.clip((t - t[0]) / 0.5, 0.0, 1.0)))
    drive[:, 0] *= 0.01 / np.abs(drive[:, 0]).max()
    for _ in range(3):
        fine = trajectory(replace(motion, drive=drive), NO_EFFECT, base)[LEAD_SAMPLES * SUBSTEPS :]
        drive *= min(
            PEAK_VELOCITY / np.abs(fine[:, OV]).max(), PEAK_STROKE / np.abs(fine[:, OX]).max()
        )
    return replace(motion, drive=drive)


def resampled(motion: Motion, case: Case, rate: float) -> Columns:
    """Noiseless columns of one record at another rate, off the fine trajectory; the duty's steps lie on both grids.

    Raises:
        BlindError: an effect of the force channel that is made of samples at 200 Hz.
    """
    table = case.table
    if any(table[k, 0] != 0.0 for k in (OUT_HUM, OUT_DRIFT, OUT_RESONANCE, OUT_CROSSTALK)):
        raise BlindError("condition: expected an effect that acts between samples, too")
    duty = np.repeat(motion.duty[::_HELD], _HELD)[: motion.duty.size]
    fine = instruments(trajectory(replace(motion, duty=duty), table, case.base), table)
    t = np.arange(round(case.seconds * rate)) / rate
    at, grid = t + LEAD_SAMPLES * SAMPLE, np.arange(fine.shape[0]) * STEP

    def seen(signal: Array, late: float = 0.0) -> Array:
        return np.asarray(np.interp(at - late, grid, signal))

    columns = (
        t, seen(motion.drive[::2, 0]), seen(fine[:, OX]), seen(fine[:, OV]),
        duty[np.floor(at / SAMPLE + 1e-6).astype(np.intp)], seen(fine[:, OF], table[FORCE_DELAY, 0]),
        seen(fine[:, OAS]), seen(fine[:, OAU]),
    )  # fmt: skip
    return dict(zip(COLUMNS, columns, strict=True))


def without(*names: str) -> Callable[[Columns, Random], Columns]:
    """A file that lacks columns."""

    def changed(columns: Columns, rng: Random) -> Columns:
        del rng
        return {k: v for k, v in columns.items() if k not in names}

    return changed


def scaled(**factors: float) -> Callable[[Columns, Random], Columns]:
    """A file whose columns are a multiple of what they should be."""

    def changed(columns: Columns, rng: Random) -> Columns:
        del rng
        return {k: v * factors.get(k, 1.0) for k, v in columns.items()}

    return changed


def force_later(seconds: float) -> Callable[[Columns, Random], Columns]:
    """A force whose clock is late (negative: early) by whole samples; the ends hold."""

    def changed(columns: Columns, rng: Random) -> Columns:
        del rng
        shift = round(seconds / float(columns["t"][1] - columns["t"][0]))
        at = np.clip(np.arange(columns["t"].size) - shift, 0, columns["t"].size - 1)
        return {**columns, "damper_force": columns["damper_force"][at]}

    return changed


def stamped(columns: Columns, rng: Random) -> Columns:
    """Stamps 1 ms off either way, 0.5 % of the rows twice, 1 % of them missing."""
    n = columns["t"].size
    times = np.where(rng.random(n) < 0.005, 2, 1)
    times[rng.random(n) < 0.01] = 0
    late = {**columns, "t": columns["t"] + rng.uniform(-1e-3, 1e-3, n)}
    return {k: np.repeat(v, times) for k, v in late.items()}


def off(share: float) -> Callable[[Model, Random], Model]:
    """A model whose values are off by up to a share, beside what the truth is off by."""

    def changed(model: Model, rng: Random) -> Model:
        for name, values in model.effects.items():
            moved = {k: v * (1.0 + rng.uniform(-share, share)) for k, v in values.items()}
            model = model.with_effect(name, moved)
        return model

    return changed


_LARGE = scaled(
    damper_force=30.0, road=3.0, deflection=3.0, deflection_velocity=3.0, sprung_acceleration=3.0,
    unsprung_acceleration=3.0,
)  # fmt: skip
_ACCELERATIONS = ("sprung_acceleration", "unsprung_acceleration")
CONDITIONS: dict[str, Condition] = {
    "nominal": Condition("as the score: one record of 60 s at 200 Hz"),
    "rate_100": Condition("sampled at 100 Hz", rate=100.0),
    "rate_500": Condition("sampled at 500 Hz", rate=500.0),
    "force_quiet": Condition("force noise 0.2 times", noise=Noise(force=0.03)),
    "force_loud": Condition("force noise 4 times", noise=Noise(force=0.6)),
    "motion_quiet": Condition("motion noise 0.2 times", noise=Noise(0.15, 2e-4, 4e-6, 5e-3)),
    "motion_loud": Condition("motion noise 3 times", noise=Noise(0.15, 3e-3, 6e-5, 0.075)),
    "no_accelerations": Condition(
        "deflection, velocity, force and duty only", file=without("road", *_ACCELERATIONS)
    ),
    "deflection_only": Condition(
        "deflection, force and duty only",
        file=without("road", "deflection_velocity", *_ACCELERATIONS),
    ),
    "velocity_only": Condition(
        "velocity, force and duty only", file=without("road", "deflection", *_ACCELERATIONS)
    ),
    "records_2": Condition("two records of 40 s", size=Layout(2, 40.0)),
    "records_3": Condition("three records of 25 s", size=Layout(3, 25.0)),
    "records_10": Condition("ten records of 10 s", size=Layout(10, 10.0)),
    "stamps": Condition("stamps 1 ms off, rows twice or missing", file=stamped),
    "few_steps": Condition("four duties of 0.05 to 0.3, few steps", inputs=few_steps),
    "slow_sine": Condition("duty along a slow sine", inputs=slow_sine),
    "narrow_band": Condition("motion of 1 to 3 Hz only", inputs=narrow_band),
    "base_25": Condition("model values 25 % further off", model=off(0.25)),
    "base_bingham": Condition(
        "a Bingham model", model_file="inove_bingham_dynamic.yaml", another_form=True
    ),
    "base_static": Condition(
        "a model without response time", model_file="inove_guo_static.yaml", adds=("response",)
    ),
    "large": Condition("force 30 times, stroke 3 times", file=_LARGE),
    "force_late": Condition("force 5 ms late", file=force_later(0.005), adds=("force_delay",)),
    "force_early": Condition("force 5 ms early", file=force_later(-0.005), adds=("force_delay",)),
    "force_flipped": Condition(
        "force of the other sign", file=scaled(damper_force=-1.0), told="sign"
    ),
    "unit_mm": Condition("deflection in mm", file=scaled(deflection=1e3), told="looks like mm"),
    "unit_kN": Condition("force in kN", file=scaled(damper_force=1e-3), told="another unit"),
}


def changed_case(case: Case, condition: Condition, seed: int) -> Case:
    """The same truth on the bench's inputs, without and with its noise."""
    rng = np.random.default_rng([seed, 1])
    motions = tuple(condition.inputs(m, case.base, rng) for m in case.motions)
    clean = case.clean
    if condition.inputs is not same_inputs:
        clean = tuple(clean_records(motions, case.table, case.base, case.seconds))
    return replace(case, motions=motions, clean=clean, noise=condition.noise)


def measured(case: Case, condition: Condition, seed: int, folder: Path) -> Path:
    """Files of a case as this bench would have written them; returns their folder."""
    folder.mkdir(parents=True)
    for k, (motion, clean) in enumerate(zip(case.motions, case.clean, strict=True)):
        rng = np.random.default_rng([seed, 2, k])
        other_rate = condition.rate * SAMPLE != 1.0
        columns = resampled(motion, case, condition.rate) if other_rate else clean
        columns = condition.file(with_noise(columns, case.noise, rng), rng)
        table = np.stack(list(columns.values()), axis=1)
        path = folder / f"record_{k + 1}.csv"
        np.savetxt(path, table, "%.9g", delimiter=",", header=",".join(columns), comments="")
    return folder


def given(condition: Condition, seed: int, nominal: Path, folder: Path) -> Path:
    """File of the model that is given."""
    path = nominal.with_name(condition.model_file)
    if condition.model is same_model:
        return path
    model = condition.model(load_model(path), np.random.default_rng([seed, 3]))
    save_model(model, folder / "given.yaml")
    return folder / "given.yaml"

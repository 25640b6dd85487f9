"""Duty programs and experiment files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from er_models.duty import KINDS
from er_models.errors import InputError
from er_models.model import Array
from er_models.program import duty, load_program, resolve, save_program, times
from er_models.simulation import simulate
from models_help import CONFIG, DT, car, guo

T = np.arange(4000) * DT
COMPLETE: dict[str, dict[str, object]] = {
    "constant": {"level": 0.2},
    "steps": {},
    "stairs": {},
    "square": {},
    "sine": {},
    "recorded": {"values": [0.0, 0.3, 0.1], "dt": 1.0},
    "sequence": {
        "parts": [
            {"kind": "constant", "seconds": 2.0, "level": 0.1},
            {"kind": "steps", "seconds": 5.0, "high": 0.2},
        ],
    },
}


def levels(kind: str, t: Array = T, seed: int = 0, **settings: object) -> Array:
    return duty({"kind": kind, **COMPLETE[kind], **settings}, t, seed)


def test_every_kind_is_tested() -> None:
    assert set(COMPLETE) == set(KINDS)


@pytest.mark.parametrize("kind", KINDS)
def test_is_a_duty_and_the_same_in_chunks(kind: str) -> None:
    whole = levels(kind, seed=4)
    assert whole.min() >= 0.0
    assert whole.max() <= 1.0
    chunks = [levels(kind, T[i : i + 700], seed=4) for i in range(0, T.size, 700)]
    assert np.array_equal(np.concatenate(chunks), whole)


def test_steps_hold_and_reach_what_they_say() -> None:
    t = np.arange(200_000) * DT
    values = levels("steps", t, low=0.1, high=0.3, hold_min=0.3, hold_max=2.0, zero_share=0.25)
    edges = np.flatnonzero(np.diff(values)) + 1
    holds = np.diff(edges) * DT
    assert holds.min() > 0.3 - 2 * DT
    assert holds.max() < 4 * 2.0
    assert np.median(holds) == pytest.approx(1.15, rel=0.3)
    lit = values[values > 0.0]
    assert lit.min() >= 0.1
    assert lit.max() <= 0.3
    assert np.ptp(lit) > 0.19
    assert (values == 0.0).mean() == pytest.approx(0.25, abs=0.05)
    assert not np.array_equal(levels("steps", seed=1), levels("steps", seed=2))


def test_stairs_and_square_change_on_the_sample() -> None:
    """Times are multiples of a sample that has no exact binary form: no step may come one late."""
    t = np.arange(100_000) * 1e-3
    stairs = levels("stairs", t, levels=[0.0, 0.1, 0.2], hold=0.1)
    assert set((np.flatnonzero(np.diff(stairs)) + 1) % 100) == {0}
    square = levels("square", t, frequency=5.0, low=0.05, high=0.3)
    assert set((np.flatnonzero(np.diff(square)) + 1) % 100) == {0}
    assert square[0] == 0.3
    assert square[100] == 0.05
    assert levels("square", t, frequency=5.0, share=0.2).mean() == pytest.approx(0.06, rel=0.01)


def test_sine_is_cut_off() -> None:
    values = levels("sine", mean=0.1, amplitude=0.2)
    assert values.min() == 0.0
    assert values.max() == pytest.approx(0.3, rel=1e-3)


def test_a_sequence_changes_part_on_the_sample() -> None:
    parts = [{"kind": "constant", "seconds": s, "level": s} for s in (0.1, 0.3, 0.2)]
    values = duty({"kind": "sequence", "parts": parts}, np.arange(100_000) * 1e-3)
    assert set((np.flatnonzero(np.diff(values)) + 1) % 600) == {0, 100, 400}
    assert values[:600].mean() == pytest.approx((0.1**2 + 0.3**2 + 0.2**2) / 0.6)


def test_recorded_is_held() -> None:
    t = np.array([0.0, 0.99, 1.0, 1.5, 2.0, 5.0])
    assert levels("recorded", t).tolist() == [0.0, 0.0, 0.3, 0.3, 0.1, 0.1]
    again = levels("recorded", np.array([3.0, 4.0, 5.9]), after="repeat")
    assert again.tolist() == [0.0, 0.3, 0.1]


MISTAKES: dict[str, tuple[dict[str, object], str]] = {
    "unknown kind": ({"kind": "step"}, r"duty: kind: .* found 'step' \(did you mean steps\?\)"),
    "unknown key": ({"kind": "constant", "value": 0.2}, "duty: value: expected one of kind, level"),
    "too large": ({"kind": "constant", "level": 1.2}, "duty: level: expected 0 to 1 duty, found 1.2"),
    "exchanged": ({"kind": "steps", "low": 0.5}, "duty: low: expected at most high, 0.3, found 0.5"),
    "exchanged holds": ({"kind": "steps", "hold_min": 5.0}, "duty: hold_min: expected at most hold_max"),
    "no levels": ({"kind": "stairs", "levels": []}, "duty: levels: expected one or more levels"),
    "recorded volts": ({"kind": "recorded", "values": [0.0, 3.2]}, r"duty: values\[1\]: expected 0 to 1"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_line(mistake: str) -> None:
    spec, message = MISTAKES[mistake]
    with pytest.raises(InputError, match=message):
        duty(spec, T, 0)


PROGRAM = """
schema: er_program 1
duration: 2.0
seed: 3
road: {kind: iso8608, road_class: C, speed: 15.0, peak_velocity: 0.1}
duty: {kind: recorded, file: duty.csv}
"""


def written(folder: Path, text: str = PROGRAM) -> Path:
    (folder / "duty.csv").write_text("t,duty\n0,0.1\n1,0.3\n", encoding="utf-8")
    path = folder / "drive.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_program_is_read_and_resolved_for_a_car(tmp_path: Path) -> None:
    program = load_program(written(tmp_path))
    assert (program.name, program.duration, program.seed) == ("drive", 2.0, 3)
    ready = resolve(program, car(), DT)
    t = times(ready.duration, DT)
    assert t.size == 401
    assert t[-1] == pytest.approx(2.0)
    road, levels_ = ready.signals(t)
    assert set(levels_) == {0.1, 0.3}
    passive = simulate(car(), DT, ready.ride(DT)[0], np.zeros(t.size))
    assert np.abs(passive["deflection_velocity"]).max() == pytest.approx(0.1, rel=1e-3)
    assert resolve(ready, car(), DT) is ready
    again = load_program(written(tmp_path))
    assert np.array_equal(resolve(again, car(), DT).signals(t)[0], road)


@pytest.mark.parametrize("moves", ["wheel", "damper"])
def test_a_written_program_is_read_again(moves: str, tmp_path: Path) -> None:
    text = f"""
    schema: er_program 1
    source: made up
    duration: 3.0
    seed: 7
    moves: {moves}
    road: {{kind: sequence, fade: 0.1, parts: [
      {{kind: multisine, seconds: 1.0, amplitudes: [0.001, 0.002], frequencies: [1, 2]}},
      {{kind: iso8608, seconds: 1.5, road_class: A}}]}}
    duty: {{kind: stairs, levels: [0.0, 0.2], hold: 0.5}}
    """
    program = load_program(written(tmp_path, text))
    save_program(program, tmp_path / "again.yaml")
    again = load_program(tmp_path / "again.yaml")
    assert (again.moves, again.source, again.seed) == (moves, "made up", 7)
    t = times(3.0, DT)
    for a, b in zip(program.signals(t), again.signals(t), strict=True):
        assert np.array_equal(a, b)


def test_peak_velocity_needs_a_car(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="quarter_car"):
        resolve(load_program(written(tmp_path)), guo(), DT)


FILE_MISTAKES = {
    "unknown key": ("seed: 3", "sead: 3", r"sead: .* an unknown key \(did you mean seed\?\)"),
    "no schema": ("schema: er_program 1", "name: x", "schema: expected 'er_program 1', found nothing"),
    "other schema": ("er_program 1", "er_model 1", "schema: expected one of er_program 1"),
    "no duration": ("duration: 2.0\n", "", "duration: expected duration; 0 for no end, found nothing"),
    "half a seed": ("seed: 3", "seed: 3.5", "seed: expected a whole number, found 3.5"),
    "no road": ("road: {", "# {", "road: expected a mapping with kind"),
    "unknown road key": ("speed:", "sped:", r"road.sped: .* \(did you mean speed\?\)"),
    "road kind": ("iso8608", "iso", "road.kind: expected one of"),
    "bad value": ("15.0", "-15.0", "road.speed: expected 0 to 150 m/s, found -15"),
    "road as number": ("road: {kind: iso8608, road_class: C, speed: 15.0, peak_velocity: 0.1}", "road: 3",
                       "road: expected a mapping with 'kind'"),
    "both scales": ("peak_velocity: 0.1", "peak_velocity: 0.1, factor: 0.2",
                    "road.peak_velocity: expected either factor or peak_velocity"),
    "no such file": ("duty.csv", "dutty.csv", "dutty.csv: expected a .csv or .parquet file, found no file"),
    "a list": ("schema: er_program 1", "- 1", "expected valid YAML"),
    "twice": ("seed: 3", "seed: 3\nseed: 4", "line 5: expected valid YAML, found the key 'seed' twice"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", FILE_MISTAKES)
def test_a_mistake_in_a_file_names_the_file(mistake: str, tmp_path: Path) -> None:
    old, new, message = FILE_MISTAKES[mistake]
    assert old in PROGRAM
    path = written(tmp_path, PROGRAM.replace(old, new))
    with pytest.raises(InputError, match=message) as caught:
        load_program(path)
    assert str(caught.value).startswith(str(tmp_path))
    assert "\n" not in str(caught.value)
    assert caught.value.exit_status == 2


def test_no_program_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="expected a program file, found no file"):
        load_program(tmp_path / "nothing.yaml")


@pytest.mark.parametrize(
    ("path", "limit"),
    [
        (
            path,
            1.0 if path.stem == "car_iso" else car().rig["duty_max"],
        )  # it is for dampers in full size
        for path in sorted(CONFIG.glob("experiments/*.yaml"))
    ]
    + [(path, 1.0) for path in sorted(CONFIG.glob("simulations/*.yaml"))],
    ids=lambda given: given.stem if isinstance(given, Path) else "",
)
def test_the_programs_of_the_repository_are_good(path: Path, limit: float) -> None:
    """What is for a rig stays below its duty; what is only simulated, within the model's."""
    program = resolve(load_program(path), car(), DT)
    road, levels_ = program.signals(times(min(program.duration or 5.0, 5.0), DT))
    assert np.isfinite(road).all()
    assert levels_.max() <= limit + 1e-12

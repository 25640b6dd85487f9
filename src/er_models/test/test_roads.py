"""Roads: shape, spectrum, repeatability, and mistakes in their settings."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from er_models.errors import InputError
from er_models.model import Array
from er_models.road import KINDS, road_profile
from er_models.road.iso8608 import CLASSES, mean_density
from er_models.road.peak import factor_for_peak_velocity
from er_models.simulation import simulate
from models_help import DT, car, guo
from scipy.signal import welch

T = np.arange(4000) * DT
COMPLETE: dict[str, dict[str, object]] = {
    "flat": {"height": 0.01},
    "sine": {"amplitude": 0.004, "frequency": 2.0},
    "triangle": {"amplitude": 0.004, "frequency": 2.0},
    "multisine": {"amplitudes": [0.004, 0.001], "frequencies": [2.0, 7.0]},
    "chirp": {},
    "step": {"height": 0.02},
    "bumps": {},
    "iso8608": {},
    "recorded": {"values": [0.0, 0.01, -0.01, 0.0], "dt": 2.0},
    "sequence": {
        "parts": [
            {"kind": "sine", "seconds": 3.0, "amplitude": 0.004, "frequency": 2.0},
            {"kind": "iso8608", "seconds": 2.5, "factor": 0.2},
        ],
    },
}


def road(kind: str, t: Array = T, seed: int = 0, **settings: object) -> Array:
    return road_profile({"kind": kind, **COMPLETE[kind], **settings}, t, seed)


def test_every_kind_is_tested() -> None:
    assert set(COMPLETE) == set(KINDS)


@pytest.mark.parametrize("kind", KINDS)
def test_is_the_same_in_chunks_and_backwards(kind: str) -> None:
    """A node asks for its road piece by piece."""
    whole = road(kind)
    chunks = [road(kind, T[i : i + 700]) for i in range(0, T.size, 700)]
    assert np.allclose(np.concatenate(chunks), whole, rtol=0.0, atol=1e-14)
    assert np.allclose(road(kind, T[::-1])[::-1], whole, rtol=0.0, atol=1e-14)
    assert np.array_equal(road(kind), whole)


@pytest.mark.parametrize("kind", KINDS)
def test_factor_scales_the_height(kind: str) -> None:
    assert road(kind, factor=-0.2) == pytest.approx(-0.2 * road(kind), abs=1e-15)
    assert np.ptp(road(kind)) > 0.0 or kind == "flat"


def test_sine() -> None:
    t = np.array([0.0, 0.125, 0.25])
    assert road("sine", t, phase=np.pi / 2) == pytest.approx([0.004, 0.0, -0.004], abs=1e-15)


def test_chirp_has_the_frequency_it_says() -> None:
    """Zero crossings by phase: cycles(t) = f0 t + (f1 - f0) t^2 / 2 T, then f1."""
    values = road("chirp", f0=1.0, f1=5.0, sweep=10.0)
    rising = T[1:][(values[:-1] < 0.0) & (values[1:] >= 0.0)]
    sweeping, after = rising[rising < 10.0], rising[rising > 10.1]
    assert sweeping.size == pytest.approx(10.0 * (1.0 + 5.0) / 2.0, abs=1)
    assert 1.0 / np.diff(after) == pytest.approx(5.0, rel=0.03)
    assert np.abs(np.diff(values)).max() < 0.004 * 2.0 * np.pi * 5.0 * DT * 1.01


def test_triangle_has_one_velocity_except_at_its_corners() -> None:
    values = road("triangle", np.arange(4000) * 5e-4, sharpness=0.999)
    speed = np.abs(np.diff(values)) / 5e-4
    assert np.median(speed) == pytest.approx(4.0 * 0.004 * 2.0, rel=0.03)
    assert (np.abs(speed / np.median(speed) - 1.0) < 0.1).mean() > 0.8
    nearly_a_sine = road("triangle", sharpness=0.01)
    assert nearly_a_sine == pytest.approx(road("sine"), abs=1e-7)


def test_multisine_has_the_lines_it_says() -> None:
    spectrum = np.abs(np.fft.rfft(road("multisine", seed=5))) * 2.0 / T.size
    frequency = np.fft.rfftfreq(T.size, DT)
    lines = np.flatnonzero(spectrum > 1e-4)
    assert frequency[lines] == pytest.approx([2.0, 7.0])
    assert spectrum[lines] == pytest.approx([0.004, 0.001])
    assert not np.allclose(road("multisine", seed=5), road("multisine", seed=6))


def test_sequence_goes_on_and_begins_again_without_a_jump() -> None:
    values = road("sequence", seed=4, fade=0.2)
    inside = (T > 0.2) & (T < 2.8)
    assert values[inside] == pytest.approx(road("sine")[inside])
    later = (T > 3.2) & (T < 5.3)
    random = road("iso8608", np.maximum(T - 3.0, 0.0), 5, factor=0.2)
    assert values[later] == pytest.approx(random[later])
    assert values[1100:] == pytest.approx(values[:-1100], abs=1e-12)
    assert np.abs(values[[600, 1100, 1700]]).max() < 1e-9
    sudden = np.abs(np.diff(road("sequence", seed=4, fade=0.0)))
    assert sudden[1099] > 100.0 * np.abs(np.diff(values))[1099]


def test_step_rises_once() -> None:
    sudden = road("step", rise=0.0, time=1.0)
    assert np.flatnonzero(np.diff(sudden)).tolist() == [199]
    smooth = road("step", rise=0.1, time=1.0)
    assert smooth[200] == 0.0
    assert smooth[210] == pytest.approx(0.01)
    assert smooth[220] == pytest.approx(0.02)
    assert np.all(np.diff(smooth) >= 0.0)


def test_bumps_come_at_the_speed_of_the_car() -> None:
    values = road("bumps", height=0.01, length=2.0, spacing=10.0, speed=20.0, start=5.0, count=3)
    on = values > 1e-6
    assert values.max() == pytest.approx(0.01, rel=1e-2)
    assert values[np.searchsorted(T, (5.0 + 1.0) / 20.0)] == pytest.approx(0.01, rel=1e-2)
    assert np.flatnonzero(np.diff(on.astype(int)) == 1).size == 3
    assert on.sum() * DT == pytest.approx(3 * 2.0 / 20.0, abs=4 * DT)
    assert not on[T > (5.0 + 2 * 10.0 + 2.0) / 20.0].any()


def test_spectrum_is_that_of_the_class() -> None:
    """Welch's estimate over bands of a third octave, averaged over seeds, stays in the class.

    The limits of ISO 8608 are half and twice the geometric mean; the mean itself is met within 15 %.
    """
    speed, dt = 20.0, 2.5e-3
    t = np.arange(2**15) * dt
    spectra = []
    for seed in range(2):
        height = road("iso8608", t, seed, road_class="A", speed=speed)
        n, density = welch(height, fs=1.0 / (dt * speed), nperseg=2**13, detrend="linear")
        spectra.append(density)
    density = np.mean(spectra, axis=0)
    mean = mean_density("A") * (np.maximum(n, 1e-9) / 0.1) ** -2.0
    ratios = []
    for low in 0.03 * 2.0 ** (np.arange(19) / 3.0):
        band = (n >= low) & (n < low * 2.0 ** (1.0 / 3.0))
        ratios.append(density[band].mean() / mean[band].mean())
    assert min(ratios) > 0.5
    assert max(ratios) < 2.0
    assert np.exp(np.mean(np.log(ratios))) == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize("road_class", CLASSES)
def test_classes_are_the_same_road_of_other_height(road_class: str) -> None:
    """Four times the density from class to class, so twice the height."""
    height = road("iso8608", T[:100], road_class=road_class)
    factor = 2.0 ** CLASSES.index(road_class)
    assert height == pytest.approx(factor * road("iso8608", T[:100], road_class="A"), rel=1e-12)


def test_classes_are_those_of_the_standard() -> None:
    assert [mean_density(c) * 1e6 for c in CLASSES] == [16 * 4**k for k in range(8)]


def test_band_limits_hold() -> None:
    speed, dt = 20.0, 2e-3
    t = np.arange(2**14) * dt
    height = road("iso8608", t, speed=speed, n_min=0.05, n_max=0.5)
    n, density = welch(height, fs=1.0 / (dt * speed), nperseg=2**12)
    inside = density[(n > 0.06) & (n < 0.45)].mean()
    assert density[n > 0.6].max() < 1e-3 * inside
    assert abs(height[0]) < 1e-15


def test_speed_stretches_the_same_road() -> None:
    slow = road("iso8608", T, speed=10.0)
    fast = road("iso8608", T / 2.0, speed=20.0)
    assert fast == pytest.approx(slow, abs=1e-12)


def test_seed_decides() -> None:
    assert not np.allclose(road("iso8608", seed=1), road("iso8608", seed=2))


def test_recorded_values_are_joined_by_straight_lines() -> None:
    t = np.array([0.0, 1.0, 2.0, 3.0, 6.0, 9.0])
    assert road("recorded", t) == pytest.approx([0.0, 0.005, 0.01, 0.0, 0.0, 0.0])
    again = road("recorded", t, after="repeat")
    assert again[-1] == pytest.approx(road("recorded", np.array([3.0]))[0])
    assert road("recorded", t, start=2.0)[0] == pytest.approx(0.01)


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_recorded_file(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"road{suffix}"
    _write(path, {"t": [5.0, 6.0, 7.0], "road": [0.0, 0.02, 0.04], "other": [9.0, 9.0, 9.0]})
    spec = {"kind": "recorded", "file": str(path)}
    assert road_profile(spec, np.array([0.0, 0.5, 2.0])) == pytest.approx([0.0, 0.01, 0.04])
    other = road_profile({**spec, "column": "other"}, np.array([0.5]))
    assert other == pytest.approx([9.0])


def _write(path: Path, columns: dict[str, list[float]]) -> None:
    """A table file of either kind."""
    if path.suffix == ".csv":
        rows = [",".join(columns), *(",".join(map(str, row)) for row in zip(*columns.values()))]
        path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    else:
        parquet = pytest.importorskip("pyarrow.parquet")
        import pyarrow

        parquet.write_table(pyarrow.table(columns), path)


TABLES = {
    "no file": (None, "expected a .csv or .parquet file, found no file"),
    "no column": ("t,height\n0,1\n1,2\n", "road: expected a column of that name, found columns t, height"),
    "empty": ("", "t: expected a column of that name, found columns none"),
    "words": ("t,road\n0,1\n1,high\n", "road, row 2: expected a number, found 'high'"),
    "short row": ("t,road\n0,1\n1\n", "road, row 2: expected a number, found ''"),
    "not a number": ("t,road\n0,1\n1,nan\n", "road, row 2: expected a finite number, found nan"),
    "backwards": ("t,road\n0,1\n2,1\n1,1\n", "t, row 3: expected two or more increasing times, found 1 after 2"),
    "one row": ("t,road\n0,1\n", "t: expected two or more increasing times, found 1 rows"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", TABLES)
def test_a_bad_table_is_one_line(mistake: str, tmp_path: Path) -> None:
    text, message = TABLES[mistake]
    path = tmp_path / "road.csv"
    if text is not None:
        path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        road_profile({"kind": "recorded", "file": str(path)}, T)
    assert str(caught.value) == f"{path}: {message}"


def test_other_kinds_of_file_are_refused(tmp_path: Path) -> None:
    (tmp_path / "road.xlsx").write_bytes(b"x")
    with pytest.raises(InputError, match=r"expected a .csv or .parquet file, found '.xlsx'"):
        road_profile({"kind": "recorded", "file": str(tmp_path / "road.xlsx")}, T)


MISTAKES: dict[str, tuple[object, str]] = {
    "no mapping": (5, "road: expected a mapping with 'kind' and its settings, found int"),
    "no kind": ({}, "road: kind: expected one of flat, sine, .* found nothing"),
    "unknown kind": ({"kind": "iso_8608"}, r"found 'iso_8608' \(did you mean iso8608\?\)"),
    "unknown key": (
        {"kind": "sine", "amplitud": 1.0}, r"road: amplitud: .* an unknown key \(did you mean amplitude\?\)",
    ),
    "missing key": ({"kind": "sine", "frequency": 1.0}, "road: amplitude: expected half the height"),
    "text": ({"kind": "chirp", "f1": "fast"}, "road: f1: expected a number in Hz, found 'fast'"),
    "yes": ({"kind": "chirp", "f1": True}, "road: f1: expected a number in Hz, found True"),
    "NaN": ({"kind": "chirp", "f1": float("nan")}, "road: f1: expected 0 to 100 Hz, found nan"),
    "too large": ({"kind": "chirp", "amplitude": 5.0}, "road: amplitude: expected -1 to 1 m, found 5"),
    "no class": ({"kind": "iso8608", "road_class": "I"}, "road: road_class: expected one of A, B, .*, found 'I'"),
    "empty band": ({"kind": "iso8608", "n_min": 3.0}, "road: n_min: expected less than n_max"),
    "overlapping bumps": ({"kind": "bumps", "spacing": 1.0}, "road: spacing: expected at least the length"),
    "two lengths": ({"kind": "multisine", "amplitudes": [0.1], "frequencies": [1.0, 2.0]},
                    "road: amplitudes: expected as many amplitudes as frequencies, one or more, found 1 and 2"),
    "no parts": ({"kind": "sequence", "parts": []}, "road: parts: expected one or more parts, found none"),
    "part without length": ({"kind": "sequence", "parts": [{"kind": "flat"}]},
                            r"road: parts\[0\].seconds: expected length of the part, found nothing"),
    "bad part": ({"kind": "sequence", "parts": [{"kind": "flat", "seconds": 1.0, "hight": 0.1}]},
                 r"road: parts\[0\].hight: .* \(did you mean height\?\)"),
    "parts of parts": ({"kind": "sequence", "parts": [{"kind": "sequence", "seconds": 1.0}]},
                       r"road: parts\[0\].kind: expected one of flat, sine"),
    "neither": ({"kind": "recorded"}, "road: file: expected either 'file' or 'values' with 'dt', found neither"),
    "both": ({"kind": "recorded", "file": "a.csv", "values": [1.0]}, "found both"),
    "bad value": ({"kind": "recorded", "values": [0.0, "x"]}, r"road: values\[1\]: expected a number in m"),
    "no list": ({"kind": "recorded", "values": 1.0}, "road: values: expected a list of numbers in m"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_line(mistake: str) -> None:
    spec, message = MISTAKES[mistake]
    with pytest.raises(InputError, match=message) as caught:
        road_profile(spec, T)  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("begin", [0.0, 17.77], ids=("from rest", "later"))
def test_even_samples_lie_on_the_same_random_road_as_uneven_ones(begin: float) -> None:
    even = begin + np.arange(3000) * DT
    uneven = np.delete(even, np.arange(0, even.size, 7))
    spec = {"kind": "iso8608", "road_class": "E"}
    height, among = road_profile(spec, even, seed=5), road_profile(spec, uneven, seed=5)
    assert np.abs(np.delete(height, np.arange(0, even.size, 7)) - among).max() < 1e-12
    assert height.std() > 1e-3


@pytest.mark.parametrize("model", [car(), car().with_effect("end_stop")], ids=("linear", "bent"))
def test_peak_velocity_is_reached(model: object) -> None:
    height = road("iso8608", seed=3)
    factor = factor_for_peak_velocity(model, height, DT, 0.12)  # type: ignore[arg-type]
    run = simulate(model, DT, factor * height, np.zeros(T.size))  # type: ignore[arg-type]
    assert np.abs(run["deflection_velocity"]).max() == pytest.approx(0.12, rel=1e-3)


def test_peak_velocity_of_a_road_that_moves_nothing() -> None:
    with pytest.raises(InputError, match="peak_velocity: expected a road that moves the car"):
        factor_for_peak_velocity(car(), np.zeros(100), DT, 0.12)
    with pytest.raises(InputError, match="quarter_car"):
        factor_for_peak_velocity(guo(), np.ones(100), DT, 0.12)

"""MDF 4: channels with units and time axes of their own, and damaged files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("asammdf")
from asammdf import MDF, Signal
from er_models.errors import InputError
from er_records.load import load
from er_records.record import Array

N, DT = 800, 0.005
T = DT * np.arange(N)
X = 4e-3 * np.sin(2 * np.pi * T)


def signal(name: str, samples: Array, unit: str = "", t: Array = T) -> Signal:
    """A channel as a logger writes it."""
    return Signal(samples=samples, timestamps=t, name=name, unit=unit)


def save(path: Path, *groups: list[Signal]) -> Path:
    """Write channel groups to a file."""
    with MDF(version="4.10") as mdf:
        for group in groups:
            mdf.append(group)
        mdf.save(path, overwrite=True)
    return path


def test_units_are_converted_and_channels_brought_to_one_time_axis(tmp_path: Path) -> None:
    slow = T[::10]
    path = save(
        tmp_path / "car.mf4",
        [signal("deflection", 1e3 * X, "mm"), signal("damper_force", 500.0 * X, "N")],
        [signal("duty", np.where(slow < 2.0, 0.0, 40.0), "%", slow)],
        [signal("engine_rpm", np.ones(N), "rpm")],
    )
    (record,) = load([path])
    np.testing.assert_allclose(record.channels["deflection"], X, atol=1e-12)
    np.testing.assert_allclose(record.channels["damper_force"], 500.0 * X, atol=1e-12)
    duty = record.channels["duty"]
    assert set(np.unique(duty)) == {0.0, 0.4}
    assert record.t[np.flatnonzero(duty)[0]] == pytest.approx(2.0)
    assert "deflection converted from mm to m" in record.notes
    assert any(note.startswith("duty is sampled at other times") for note in record.notes)
    assert any("1 other channel" in note for note in record.notes)
    assert record.has("deflection_velocity")


def test_a_channel_that_starts_later_cuts_the_record_and_is_not_invented(tmp_path: Path) -> None:
    late = T[200:] + 0.001
    groups = [signal("deflection", X)], [signal("damper_force", np.full(late.size, 7.0), t=late)]
    (record,) = load([save(tmp_path / "car.mf4", *groups)])
    assert record.t[0] == pytest.approx(T[201])
    assert not record.complete
    np.testing.assert_allclose(record.channels["damper_force"], 7.0)


def test_other_names_are_given_by_a_names_file(tmp_path: Path) -> None:
    path = save(tmp_path / "car.mf4", [signal("Susp_FL_Defl", 1e3 * X, "mm")])
    with pytest.raises(InputError, match=r"columns.*deflection"):
        load([path])
    (tmp_path / "car.mf4.names.yaml").write_text("deflection: Susp_FL_Defl\n")
    (record,) = load([path])
    np.testing.assert_allclose(record.channels["deflection"], X, atol=1e-12)


def test_a_channel_without_unit_is_taken_as_si_and_noted(tmp_path: Path) -> None:
    (record,) = load([save(tmp_path / "car.mf4", [signal("deflection", X)])])
    assert "deflection carries no unit, taken as SI" in record.notes
    np.testing.assert_array_equal(record.channels["deflection"], X)


def test_two_channels_of_one_name_and_unknown_units_are_refused(tmp_path: Path) -> None:
    twice = save(tmp_path / "two.mf4", [signal("deflection", X)], [signal("deflection", X)])
    with pytest.raises(InputError, match=r"two.mf4: channel 'deflection'.*found 2"):
        load([twice])
    odd = save(tmp_path / "odd.mf4", [signal("deflection", X, "furlong")])
    with pytest.raises(InputError, match="furlong"):
        load([odd])


@pytest.mark.parametrize("share", [0.0, 0.01, 0.3])
def test_a_damaged_file_is_named(tmp_path: Path, share: float) -> None:
    data = save(tmp_path / "whole.mf4", [signal("deflection", X)]).read_bytes()
    path = tmp_path / "cut.mf4"
    path.write_bytes(data[: int(share * len(data))])
    with pytest.raises(InputError) as caught:
        load([path])
    assert "cut.mf4" in str(caught.value)
    assert "\n" not in str(caught.value)
    path.write_bytes(b"this is no measurement at all, " * 40)
    with pytest.raises(InputError, match="MDF 4"):
        load([path])

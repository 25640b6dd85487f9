"""Folders in foreign shape, made anew with random names, units, signs and sizes, are understood by themselves."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

pytest.importorskip("nptdms")
pytest.importorskip("pyarrow")
import yaml
from er_models.errors import ErError, InputError
from er_records.load import load
from er_records.mapping.guess import nice
from er_records.mapping.mapping import mapped
from er_records.mapping.words import WORDS as KNOWN
from er_records.mapping.words import fits
from er_records.readers.units import unit_in_name
from nptdms import ChannelObject, TdmsWriter
from scipy.io import savemat

RATE, SECONDS = 250.0, 12.0
T = np.arange(0.0, SECONDS, 1.0 / RATE)
Columns = dict[str, tuple[np.ndarray, str]]

WORDS = {
    "t": ["Zeit", "Time", "Messzeit", "t", "Zeitstempel"],
    "deflection": ["Weg", "Kolbenweg", "Displacement", "Stroke_VL", "Hub", "rPosition", "Einfederweg"],
    "deflection_velocity": ["Geschwindigkeit", "Velocity", "v_Kolben", "Kolbengeschw", "speed"],
    "duty": ["Strom", "Coil current", "Spulenspannung", "PWM", "I_ist"],
    "damper_force": ["Kraft", "Force", "Dämpferkraft", "Load_Cell", "rKraft_HR"],
    "temperature": ["Temperatur", "OilTemp", "T_Öltemperatur"],
}  # fmt: skip
UNITS = {
    "t": {"s": 1.0, "ms": 1e-3, "min": 60.0},
    "deflection": {"mm": 1e-3, "m": 1.0, "cm": 1e-2, "in": 0.0254, "inch": 0.0254},
    "deflection_velocity": {"mm/s": 1e-3, "m/s": 1.0, "in/s": 0.0254},
    "duty": {"A": 1.0, "V": 1.0, "mA": 1.0, "%": 1e-2},
    "damper_force": {"N": 1.0, "kN": 1e3, "lbf": 4.4482216152605, "kip": 4448.2216152605, "daN": 10.0},
    "temperature": {"°C": 1.0, "deg F": 5.0 / 9.0, "K": 1.0},
}  # fmt: skip


def truth(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """A damper of any size along a motion of several tones [SI]."""
    force, stroke = 10 ** rng.uniform(np.log10(20.0), np.log10(50e3)), rng.uniform(0.005, 0.2)
    f = rng.uniform(0.5, 1.5)
    x = stroke / 2.2 * (np.sin(2 * np.pi * f * T) + 0.1 * np.sin(2 * np.pi * 2.7 * f * T + 1.0))
    v = np.gradient(x, T)
    u = np.repeat(rng.permutation([0.0, 0.3, 0.6, 1.0]), T.size // 4)
    F = force * (0.4 * v / np.max(v) + (0.1 + 0.4 * u) * np.tanh(v / (0.02 * np.max(v))))
    F += rng.normal(0.0, 2e-3 * force, T.size)
    return {
        "t": T + 3.0, "deflection": x, "deflection_velocity": v, "duty": u, "damper_force": F,
        "temperature": np.linspace(20.0, 30.0, T.size),
    }  # fmt: skip


def foreign(
    rng: np.random.Generator, data: dict[str, np.ndarray]
) -> tuple[Columns, dict[str, str]]:
    """The same with names, units and signs of somebody's own, among columns of no interest; names by channel."""
    columns: Columns = {"Zyklus": (np.floor(T), "")}
    named = {}
    for channel in rng.permutation([*data]):
        name = str(rng.choice(WORDS[channel]))
        unit = str(rng.choice([*UNITS[channel]]))
        y = data[channel]
        if channel == "temperature":
            y = y * 1.8 + 32.0 if unit == "deg F" else y
        elif channel == "duty":
            y = y * (100.0 if unit == "%" else 10 ** rng.uniform(-1, 2))
        else:
            y = y / UNITS[channel][unit]
        turned = (channel == "damper_force" and rng.random() < 0.5) or name == "Einfederweg"
        columns[name] = (-y if turned else y, unit)
        named[channel] = name
    columns["Bemerkung"] = (np.zeros(T.size), "")
    return columns, named


def text(columns: Columns, path: Path, rng: np.random.Generator) -> None:
    """A text table with units in brackets or in a row, any delimiter, decimal commas, a preamble."""
    delimiter = str(rng.choice([";", "\t", ","]))
    decimal = "." if delimiter == "," else str(rng.choice([",", "."]))
    row = rng.random() < 0.5
    heads = [n if row or not u else f"{n} [{u}]" for n, (_, u) in columns.items()]
    lines = ["Prüfstand 7", "Bediener: Müller"] * int(rng.integers(2)) + [delimiter.join(heads)]
    lines += [delimiter.join(u for _, u in columns.values())] * row
    for values in np.column_stack([y for y, _ in columns.values()]).tolist():
        lines.append(delimiter.join(f"{v:.9g}".replace(".", decimal) for v in values))
    path.with_suffix(".csv").write_text(
        "\n".join(lines) + "\n", encoding=str(rng.choice(["utf-8", "cp1252"]))
    )


def parquet(columns: Columns, path: Path, _: np.random.Generator) -> None:
    """A table with units in brackets."""
    pq.write_table(
        pa.table({f"{n} ({u})": y for n, (y, u) in columns.items()}), path.with_suffix(".parquet")
    )


def tdms(columns: Columns, path: Path, _: np.random.Generator) -> None:
    """Channels with units as properties."""
    channels = [ChannelObject("G", n, y, {"unit_string": u}) for n, (y, u) in columns.items()]
    with TdmsWriter(path.with_suffix(".tdms")) as writer:
        writer.write_segment(channels)


@pytest.mark.parametrize("write", [text, parquet, tdms])
@pytest.mark.parametrize("seed", range(4))
def test_a_foreign_folder_is_understood(
    seed: int, write: Callable[[Columns, Path, np.random.Generator], None], tmp_path: Path
) -> None:
    rng = np.random.default_rng([seed, len(write.__name__)])
    data = truth(rng)
    columns, named = foreign(rng, data)
    write(columns, tmp_path / "run", rng)
    found = mapped(tmp_path)
    assert found.trouble == ""
    assert {c: g.seen.name for c, g in found.guesses.items()} == named
    assert all(g.sure >= 0.5 for g in found.guesses.values())
    found.save()
    (record,) = load([tmp_path])
    for channel in data.keys() - {"t"}:
        wanted = data[channel]
        spread = float(np.ptp(wanted))
        tolerance = 0.021 if channel == "duty" else 1e-5
        np.testing.assert_allclose(record.channels[channel], wanted, atol=tolerance * spread)
    assert record.dt == pytest.approx(1.0 / RATE, rel=1e-4)


def test_physics_finds_what_no_name_tells(tmp_path: Path) -> None:
    data = truth(np.random.default_rng(5))
    own = {
        "AI0": -data["damper_force"], "AI1": data["duty"], "AI2": data["deflection_velocity"],
        "AI3": data["deflection"], "AI4": data["t"],
    }  # fmt: skip
    savemat(tmp_path / "run.mat", own)
    found = mapped(tmp_path / "run.mat")
    channels = {c: g.seen.name for c, g in found.guesses.items()}
    assert channels == {
        "t": "AI4", "deflection": "AI3", "deflection_velocity": "AI2", "damper_force": "AI0", "duty": "AI1",
    }  # fmt: skip
    assert found.guesses["damper_force"].source.sign == -1.0
    assert found.guesses["damper_force"].sure < found.guesses["deflection"].sure < 0.85
    assert {"damper_force", "duty"} <= found.unsure.keys()


def test_a_unit_that_is_not_stated_follows_from_the_derivative(tmp_path: Path) -> None:
    data = truth(np.random.default_rng(6))
    own = {"t": data["t"], "Weg": 1e3 * data["deflection"], "v [m/s]": data["deflection_velocity"]}
    pq.write_table(pa.table(own), tmp_path / "run.parquet")
    assert mapped(tmp_path).guesses["deflection"].unit == "mm"


def folder(tmp_path: Path) -> Path:
    """A folder with one file whose force has no unit, and with two currents."""
    data = truth(np.random.default_rng(7))
    own = {
        "Zeit [s]": data["t"], "Weg [mm]": 1e3 * data["deflection"], "Kraft": data["damper_force"],
        "Strom [A]": 2.0 * data["duty"], "I_soll [A]": 2.0 * data["duty"][::-1],
    }  # fmt: skip
    pq.write_table(pa.table(own), tmp_path / "run.parquet")
    return tmp_path


@pytest.mark.parametrize(
    ("said", "channel", "expected"),
    [
        ({"damper_force": "Kraft [kN]"}, "damper_force", {"from": "Kraft", "unit": "kN"}),
        ({"duty": "I_soll [A]"}, "duty", {"from": "I_soll", "full_scale": 2.0}),
        ({"duty": {"from": "Strom", "full_scale": 4}}, "duty", {"from": "Strom", "full_scale": 4.0}),
        ({"duty": ""}, "duty", None),
        ({"damper_force": {"from": "Kraft", "sign": -1, "offset": 3}}, "damper_force",
         {"from": "Kraft", "sign": -1, "offset": 3.0}),
        ({"t": {"rate": 250}}, "t", {"rate": 250.0}),
        ({}, "duty", {"from": "Strom", "full_scale": 2.0}),
    ],
)  # fmt: skip
def test_what_the_user_says_counts(tmp_path: Path, said: Any, channel: str, expected: Any) -> None:
    found = mapped(folder(tmp_path), said)
    assert found.names.get(channel) == expected
    assert yaml.safe_load(found.text()) == found.names


def test_the_zero_of_an_absolute_sensor_is_offered_and_not_taken(tmp_path: Path) -> None:
    """A stroke of 12.7 to 50 mm has no zero in it: what its middle would take is said, for all files of the sensor."""
    x, v = 18.65 * np.sin(8.0 * T) + 31.35, 149.2 * np.cos(8.0 * T)
    np.savetxt(
        tmp_path / "run.csv",
        np.column_stack([T, x, 3.0 * v]),
        delimiter=",",
        header="t [s],Weg [mm],Kraft [N]",
        comments="",
    )
    found = mapped(tmp_path)
    assert found.names["deflection"] == "Weg"
    assert "12.7 to 50 mm, never zero" in found.hint
    taken = yaml.safe_load(found.hint.partition("deflection='")[2].rstrip("'"))
    centred = mapped(tmp_path, {"deflection": taken})
    assert centred.hint == ""
    assert centred.records[0].channels["deflection"].max() == pytest.approx(0.01865, rel=0.01)


def test_nothing_is_overwritten_without_being_told(tmp_path: Path) -> None:
    found = mapped(folder(tmp_path))
    path = found.save()
    before = path.read_text(encoding="utf-8")
    with pytest.raises(InputError, match="--replace"):
        mapped(tmp_path, {"duty": ""}).save()
    assert path.read_text(encoding="utf-8") == before
    mapped(tmp_path, {"duty": ""}).save(replaced=True)
    assert "duty" not in yaml.safe_load(path.read_text(encoding="utf-8"))
    with pytest.raises(ErError, match=r"'Krft'.*Kraft"):
        mapped(tmp_path, {"damper_force": "Krft"})
    with pytest.raises(ErError, match="did you mean damper_force"):
        mapped(tmp_path, {"damper_forces": "Kraft"})


def test_columns_of_the_contract_need_no_mapping(tmp_path: Path) -> None:
    data = truth(np.random.default_rng(8))
    pq.write_table(pa.table(data), tmp_path / "run.parquet")
    assert mapped(tmp_path).needless


@pytest.mark.parametrize(
    ("channel", "name", "unit", "least"),
    [("damper_force", "Dämpferkraft_VL", "kN", 0.8), ("deflection", "rKolbenWeg", "mm", 0.7),
     ("deflection", "hub", "mm", 0.85),
     ("sprung_acceleration", "Beschl. Aufbau", "g", 0.7), ("unsprung_acceleration", "wheel acc", "m/s²", 0.85)],
)  # fmt: skip
def test_names_fit_in_both_languages(channel: str, name: str, unit: str, least: float) -> None:
    assert fits(channel, name, unit) >= least
    assert fits(channel, name, "Pa") == 0.0


@pytest.mark.parametrize(
    ("si", "name", "unit"),
    [("m", "disp_cm", "cm"), ("m", "zs_mm", "mm"), ("m", "weg.mm", "mm"), ("m/s", "vel_mm_s", "mm/s"),
     ("m/s", "v_mps", "m/s"), ("m/s2", "acc_ms2", "m/s2"), ("m/s2", "acc m/s2", "m/s2"), ("N", "force_N", "N"),
     ("N", "force_n", ""), ("1", "I_A", "A"), ("1", "u_mV", "mV"), ("K", "temp_C", "degC"), ("K", "oil_degF", "degF"),
     ("m", "pos_in", ""), ("1", "duty_1", ""), ("m", "mm", ""), ("m", "x_rel", ""), ("N", "force_kN", "kN")],
)  # fmt: skip
def test_a_name_ends_with_its_unit(si: str, name: str, unit: str) -> None:
    assert unit_in_name(si, name) == unit


def test_units_in_the_names_of_matlab_count(tmp_path: Path) -> None:
    data = truth(np.random.default_rng(6))
    y = {"time": data["t"], "disp_cm": 1e2 * data["deflection"], "volt": 2.5 * data["duty"]}
    savemat(tmp_path / "a.mat", y | {"force_kN": 1e-3 * data["damper_force"]})
    found = mapped(tmp_path)
    assert found.names["deflection"] == {"from": "disp_cm", "unit": "cm"}
    assert found.names["damper_force"] == {"from": "force_kN", "unit": "kN"}
    assert not found.unsure
    found.save()
    for record in load([tmp_path]):
        for channel in ("deflection", "damper_force"):
            np.testing.assert_allclose(record.channels[channel], data[channel], rtol=1e-9)


def test_a_full_scale_is_no_smaller_than_the_largest_value() -> None:
    assert [nice(v) for v in (1.6, 0.99951, 12.34, 437.0)] == [1.6, 1.0, 12.4, 437.0]


def test_a_unit_that_one_format_states_counts_for_the_one_that_cannot(tmp_path: Path) -> None:
    data = truth(np.random.default_rng(5))
    y = {"Zeit": data["t"], "Weg": 1e3 * data["deflection"], "Kraft": 1e-3 * data["damper_force"]}
    with TdmsWriter(str(tmp_path / "a.tdms")) as writer:
        units = {"Zeit": "s", "Weg": "mm", "Kraft": "kN"}
        writer.write_segment(
            [ChannelObject("g", n, v, {"unit_string": units[n]}) for n, v in y.items()]
        )
    savemat(tmp_path / "b.mat", y)
    found = mapped(tmp_path)
    assert found.names["damper_force"] == {"from": "Kraft", "unit": "kN"}
    assert [g.channel for s in found.survey.columns if (g := found.channel_of(s))] == [
        "t", "deflection", "damper_force", "t", "deflection", "damper_force",
    ]  # fmt: skip
    found.save()
    for record in load([tmp_path]):
        for channel in ("deflection", "damper_force"):
            np.testing.assert_allclose(record.channels[channel], data[channel], rtol=1e-9)


@pytest.mark.parametrize(
    ("name", "unit", "channel"),
    [
        ("Aufbauweg", "mm", "sprung_displacement"),
        ("wheel_position", "mm", "unsprung_displacement"),
        ("z_us", "m", "unsprung_displacement"),
        ("Aktorkraft", "kN", "actuator_force"),
        ("actuator force", "N", "actuator_force"),
        ("Dämpferkraft", "N", "damper_force"),
        ("Kolbenweg", "mm", "deflection"),
        ("Position_VL", "mm", "deflection"),
        ("Radbeschleunigung", "m/s2", "unsprung_acceleration"),
        ("as", "m/s2", "sprung_acceleration"),
        ("aus", "", "unsprung_acceleration"),
    ],
)
def test_channels_of_a_car_are_told_from_those_of_its_damper(
    name: str, unit: str, channel: str
) -> None:
    assert max(KNOWN, key=lambda each: fits(each, name, unit)) == channel


def test_what_the_user_says_of_a_sign_counts(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    x = np.sin(2 * np.pi * T)
    write(path, {"t [s]": T, "x [mm]": 5.0 * x, "F [N]": -np.gradient(x, T)})
    assert mapped(path).names["damper_force"] == {"from": "F", "sign": -1}
    told = mapped(path, {"damper_force": {"from": "F [N]", "sign": 1}})
    assert told.names["damper_force"] == "F"


def test_no_row_number_is_a_duty_and_no_voltage_of_a_force_a_velocity(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    x = 2.0 * np.abs((T * 0.5) % 2.0 - 1.0)
    force = np.sign(np.gradient(x, T))
    write(
        path, {"No": np.arange(1.0, T.size + 1), "t [s]": T, "a": 5.0 + x, "b": 3.5 + 0.3 * force}
    )
    found = mapped(path)
    assert "duty" not in found.guesses
    assert "deflection_velocity" not in found.guesses
    assert (found.records, found.trouble) == ((), ""), "nothing but the time is known"


def test_what_is_wrong_is_said_without_the_path_that_was_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    write(path, {"zeit": 1000.0 * T, "x [mm]": np.sin(T), "F [N]": np.cos(T)})
    found = mapped(path, {"t": "zeit"})
    assert found.trouble.startswith(
        "t: expected steps below 0.1 s, found 4 s as a rule (looks like ms)"
    )
    assert mapped(path, {"t": {"from": "zeit", "unit": "ms"}}).trouble == ""


def write(path: Path, table: dict[str, np.ndarray]) -> None:
    """A text table."""
    np.savetxt(
        path,
        np.column_stack(list(table.values())),
        delimiter=",",
        header=",".join(table),
        comments="",
    )

"""What a user says of his columns: scaled, shifted and turned, one mapping for files, folders, tables and topics."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

pytest.importorskip("pyarrow")
import yaml
from er_models.errors import ErError, InputError
from er_records.in_memory import from_frame
from er_records.load import load, read
from er_records.mapping.mapping import mapped
from er_records.readers.units import UNITS, known_unit
from rosbags.rosbag2 import Writer
from rosbags.typesys import Stores, get_typestore

N, DT = 600, 0.005
T = DT * np.arange(N)
X = 5e-3 * np.sin(2 * np.pi * 2.0 * T)
F = 60.0 * np.gradient(X, DT) + 3.0
U = np.where(T < 1.0, 0.0, 0.5)
OWN = {"Zeit": T, "Weg": 1e3 * X, "Kraft": (12.5 - F) / 1e3, "Strom [A]": 1.6 * U}
NAMES: dict[str, Any] = {
    "t": "Zeit",
    "deflection": "Weg [mm]",
    "duty": {"from": "Strom [A]", "full_scale": 1.6},
    "damper_force": {"from": "Kraft", "unit": "kN", "sign": -1, "offset": 12.5},
}


def text(
    columns: dict[str, Any], units: str = "", delimiter: str = ";", decimal: str = ","
) -> str:
    """A table as rigs write it."""
    rows = np.column_stack(list(columns.values())).tolist()
    lines = [delimiter.join(repr(v).replace(".", decimal) for v in row) for row in rows]
    return "\n".join([delimiter.join(columns), *([units] if units else []), *lines]) + "\n"


def right(record: Any) -> None:
    """Whether a record holds the motion, force and duty of this file."""
    np.testing.assert_allclose(record.channels["deflection"], X, atol=1e-9)
    np.testing.assert_allclose(record.channels["damper_force"], F, atol=1e-6)
    np.testing.assert_allclose(record.channels["duty"], U, atol=1e-9)
    assert dict(record.scales) == {"duty": "1 = 1.6 A"}
    assert "damper_force is turned round: sign -1" in record.notes
    assert "damper_force is shifted by 12.5 N" in record.notes


def test_one_mapping_serves_a_folder_a_file_and_a_table(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "a.csv").write_text(text(OWN))
    pq.write_table(pa.table(OWN), tmp_path / "b.parquet")
    (tmp_path / "names.yaml").write_text(yaml.safe_dump(NAMES))
    records = read(tmp_path)
    assert [r.name for r in records] == ["b", "a"]
    for record in records:
        right(record)
    right(load([tmp_path / "deep" / "a.csv"])[0])
    (tmp_path / "names.yaml").rename(tmp_path / "mine.yaml")
    for given in (NAMES, tmp_path / "mine.yaml", str(tmp_path / "mine.yaml")):
        right(load([tmp_path / "b.parquet"], given)[0])
    right(from_frame(pd.DataFrame(OWN), NAMES).records[0])


def test_a_file_of_its_own_names_goes_before_that_of_the_folder(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(text(OWN))
    wrong = NAMES | {"damper_force": "Kraft [kN]"}
    (tmp_path / "names.yaml").write_text(yaml.safe_dump(wrong))
    (tmp_path / "a.csv.names.yaml").write_text(yaml.safe_dump(NAMES))
    right(load([tmp_path])[0])


def test_a_file_of_a_folder_may_lack_a_column_and_a_note_says_so(tmp_path: Path) -> None:
    own = {k: v for k, v in OWN.items() if k != "Strom [A]"}
    (tmp_path / "a.csv").write_text(text(own))
    (tmp_path / "names.yaml").write_text(yaml.safe_dump(NAMES))
    (record,) = load([tmp_path])
    assert not record.has("duty")
    assert any("no column 'Strom [A]'" in n for n in record.notes)
    (tmp_path / "a.csv.names.yaml").write_text(yaml.safe_dump(NAMES))
    with pytest.raises(InputError, match=r"'Strom \[A\]', found Zeit.*\./er lab map .*a\.csv$"):
        load([tmp_path / "a.csv"])


@pytest.mark.parametrize("full", [1.0, 1.6])
def test_the_noise_of_a_current_about_its_ends_is_cut_off(full: float) -> None:
    current = full * U + np.where(np.arange(N) % 2, 0.01, -0.01)
    frame = pd.DataFrame({"t": T, "deflection": X, "I": current})
    names = {"duty": {"from": "I", "unit": "A", "full_scale": full}}
    duty = from_frame(frame, names).records[0].channels["duty"]
    assert duty.min() == 0.0
    np.testing.assert_allclose(duty, U, atol=0.011)
    with pytest.raises(InputError, match=r"0\.\.1"):
        from_frame(frame.assign(I=2.0 * frame["I"] + 0.2 * full), names)


def test_what_the_user_says_goes_before_a_column_of_that_name(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(text({**OWN, "deflection": 0.0 * T, "position": T}))
    right(load([tmp_path / "a.csv"], NAMES)[0])


@pytest.mark.parametrize("units", ["s;mm;kN;A", "[s];[mm];[kN];[A]", "(s);(mm);(kN);"])
@pytest.mark.parametrize(("delimiter", "decimal"), [(";", ","), ("\t", ","), (",", ".")])
def test_a_row_of_units_counts_with_any_delimiter(
    tmp_path: Path, units: str, delimiter: str, decimal: str
) -> None:
    own = {"t": T, "Weg": 1e3 * X, "Kraft": 1e-3 * F, "Strom": 1.6 * U}
    above = "Prüfstand 3\nBediener; Müller\n"
    body = text(own, units.replace(";", delimiter), delimiter, decimal)
    (tmp_path / "a.csv").write_text(above + body, encoding="cp1252")
    names = {
        "deflection": "Weg", "damper_force": "Kraft", "duty": {"from": "Strom", "full_scale": 1.6, "unit": "A"},
    }  # fmt: skip
    (record,) = load([tmp_path / "a.csv"], names)
    np.testing.assert_allclose(record.channels["deflection"], X, atol=1e-9)
    np.testing.assert_allclose(record.channels["damper_force"], F, atol=1e-6)
    assert dict(record.scales) == {"duty": "1 = 1.6 A"}
    assert "read as Windows-1252" in record.notes


def test_a_table_without_names_or_of_spaces_is_read_with_a_mapping(tmp_path: Path) -> None:
    bare = "\n".join(text(OWN, delimiter=" ", decimal=".").splitlines()[1:]) + "\n"
    (tmp_path / "a.txt").write_text(bare)
    places = {
        "Zeit": "column 1",
        "Weg [mm]": "column 2 [mm]",
        "Kraft": "column 3",
        "Strom [A]": "column 4 [A]",
    }
    names = {
        channel: places[each] if isinstance(each, str) else {**each, "from": places[each["from"]]}
        for channel, each in NAMES.items()
    }
    right(load([tmp_path / "a.txt"], names)[0])
    with pytest.raises(InputError, match=r"row 1.*header"):
        load([tmp_path / "a.txt"])
    (tmp_path / "NOTES.txt").write_text("one line\nof 2 words\n" * 20)
    assert len(load([tmp_path], names)) == 1


@pytest.mark.parametrize(
    ("first", "form"),
    [
        (86398.0, "{h:02d}:{m:02d}:{s:06.3f}"),
        (44000.0, "29.04.2022 {h:02d}:{m:02d}:{s:06.3f}"),
        (44000.0, "04/29/2022 {g}:{m:02d}:{s:06.3f} PM"),
    ],
)
def test_a_time_of_day_is_a_time(tmp_path: Path, first: float, form: str) -> None:
    lines = ["Uhrzeit;Weg [mm]"]
    for t, x in zip((T + first).tolist(), X.tolist(), strict=True):
        h, m, s = int(t // 3600) % 24, int(t // 60) % 60, t % 60
        lines.append(f"{form.format(h=h, g=h % 12 or 12, m=m, s=s)};{1e3 * x!r}")
    (tmp_path / "a.csv").write_text("\n".join(lines) + "\n")
    (record,) = load([tmp_path / "a.csv"], {"t": "Uhrzeit", "deflection": "Weg"})
    np.testing.assert_allclose(record.t, T, atol=1e-3)
    np.testing.assert_allclose(record.channels["deflection"], X, atol=1e-12)
    lines[300] = "gestern;1.0"
    (tmp_path / "a.csv").write_text("\n".join(lines) + "\n")
    with pytest.raises(InputError, match=r"data row 300.*time of day.*lab map"):
        load([tmp_path / "a.csv"], {"t": "Uhrzeit", "deflection": "Weg"})


def test_a_time_or_a_constant_may_be_made(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(text({"Weg": X, "Kraft": F}))
    names = {
        "t": {"rate": 200},
        "deflection": "Weg",
        "damper_force": "Kraft",
        "duty": {"value": 0.25},
    }
    (record,) = load([tmp_path / "a.csv"], names)
    np.testing.assert_allclose(record.t, T)
    assert set(record.channels["duty"]) == {0.25}


@pytest.mark.parametrize(
    ("entry", "expected"),
    [
        ({"damper_force": {"from": "Kraft", "sgn": -1}}, "one of from, unit, scale"),
        ({"damper_force": {"from": "Kraft", "sign": 2}}, "1 or -1"),
        ({"damper_force": {"from": "Kraft", "offset": "x"}}, "a number"),
        ({"damper_force": {"from": "Kraft", "full_scale": 2}}, "of a duty alone"),
        ({"duty": {"from": "Strom", "full_scale": 0}}, "above 0"),
        ({"damper_force": {"unit": "kN"}}, "'from'"),
        ({"damper_force": ["Kraft"]}, "a column's name"),
        ({"force": "Kraft"}, "did you mean"),
        ({"t": "Zeit", "deflection": "Weg", "damper_force": "Weg"}, "one channel"),
    ],
)
def test_a_wrong_mapping_is_one_line(entry: dict[str, Any], expected: str) -> None:
    with pytest.raises(ErError, match=expected) as caught:
        from_frame(pd.DataFrame(OWN), entry)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("head", "factor"),
    [("t;deflection;damper_force;Strom [A]", 1.0), ("t;deflection [furlong];damper_force;duty", 1.0),
                         ("t;deflection;damper_force;duty", 1.6), ("t;deflektion;damper_force;duty", 1.0)],
)  # fmt: skip
def test_every_error_about_a_column_ends_with_its_cure(
    tmp_path: Path, head: str, factor: float
) -> None:
    path = tmp_path / "a b.csv"
    path.write_text(text(dict(zip(head.split(";"), (T, X, F, 2.0 * factor * U), strict=True))))
    with pytest.raises(ErError) as caught:
        load([path])[0].need("duty", "to know the field")
    assert str(caught.value).endswith(f"./er lab map '{path}'")


def test_the_cure_of_a_table_in_memory_is_an_argument() -> None:
    with pytest.raises(InputError, match=r"names=\{'damper_force'"):
        from_frame(pd.DataFrame({"Zeit": T, "Weg": X}))


@pytest.mark.parametrize(
    ("si", "unit", "factor"),
    [("N", "kip", 4448.2216152605), ("N", "KIPS", 4448.2216152605), ("N", "lb", 4.4482216152605), ("K", "deg F", 5 / 9),
     ("K", "°C", 1.0), ("m/s2", "m/s²", 1.0), ("m", "µm", 1e-6), ("s", "[sec]", 1.0), ("m/s", "MM/S", 1e-3),
     ("m", "Inch", 0.0254), ("N", "kn", 1e3)],
)  # fmt: skip
def test_units_are_known_by_their_spellings(si: str, unit: str, factor: float) -> None:
    known = known_unit(si, unit)
    assert known is not None
    assert UNITS[si][known] == pytest.approx(factor)
    assert known_unit(si, "furlong") is None


def test_fahrenheit_becomes_a_difference_to_0_degc() -> None:
    frame = pd.DataFrame({"t": T, "deflection": X, "temperature [deg F]": np.full(N, 68.0)})
    (record,) = from_frame(frame).records
    np.testing.assert_allclose(record.channels["temperature"], 20.0)


def bag(path: Path) -> Path:
    """A recording of others: a load cell's wrench, a joint, and a current without a stamp."""
    store = get_typestore(Stores.ROS2_JAZZY)
    types = store.types
    with Writer(path, version=9) as writer:
        kinds = {"/loadcell": "geometry_msgs/msg/WrenchStamped", "/joints": "sensor_msgs/msg/JointState",
                 "/coil": "std_msgs/msg/Float64"}  # fmt: skip
        connections = {
            topic: writer.add_connection(topic, k, typestore=store) for topic, k in kinds.items()
        }
        vector = types["geometry_msgs/msg/Vector3"]
        for k in range(N):
            when = 1_700_000_000_000_000_000 + 5_000_000 * k
            stamp = types["builtin_interfaces/msg/Time"](when // 10**9, when % 10**9)
            header = types["std_msgs/msg/Header"](stamp, "")
            zero = vector(0.0, 0.0, 0.0)
            wrench = types["geometry_msgs/msg/Wrench"](vector(0.0, 0.0, (12.5 - F[k]) / 1e3), zero)
            empty = np.empty(0)
            sent = {
                "/loadcell": types["geometry_msgs/msg/WrenchStamped"](header, wrench),
                "/joints": types["sensor_msgs/msg/JointState"](
                    header, ["strut"], np.array([0.0, 1e3 * X[k]]), empty, empty
                ),
                "/coil": types["std_msgs/msg/Float64"](1.6 * U[k]),
            }
            for topic, message in sent.items():
                raw = store.serialize_cdr(message, kinds[topic])
                writer.write(connections[topic], when, raw)
    return path


def test_the_numbers_of_a_bag_are_surveyed_and_mapped(tmp_path: Path) -> None:
    path = bag(tmp_path / "run")
    known = {
        "deflection": {"from": "/joints.position[1]", "unit": "mm"},
        "duty": {"from": "/coil.data", "unit": "A", "full_scale": 1.6},
        "damper_force": "/loadcell.wrench.force.z [kN]",
    }
    found = mapped(path, known)
    headers = {s.header for s in found.survey.columns}
    assert {"/joints.position[0]", "/loadcell.wrench.torque.x", "/coil.data"} <= headers
    assert found.rate_of(found.guesses["damper_force"].seen) == pytest.approx(200.0)
    assert found.guesses["damper_force"].source.sign == -1.0
    assert found.save() == path / "names.yaml"
    (record,) = load([path])
    np.testing.assert_allclose(record.channels["damper_force"], F - 12.5, atol=1e-6)


def test_a_topic_and_field_of_a_bag_is_a_column(tmp_path: Path) -> None:
    path = bag(tmp_path / "run")
    with pytest.raises(ErError, match=r"\./er lab map .*run$"):
        load([path])
    names = {
        "deflection": {"from": "/joints.position[1]", "unit": "mm"},
        "damper_force": {**NAMES["damper_force"], "from": "/loadcell.wrench.force.z"},
        "duty": {"from": "/coil.data", "unit": "A", "full_scale": 1.6},
    }
    (tmp_path / "names.yaml").write_text(yaml.safe_dump(names))
    right(load([path])[0])
    right(load([tmp_path])[0])
    names["damper_force"]["from"] = "/loadcell.wrench.power"
    (tmp_path / "names.yaml").write_text(yaml.safe_dump(names))
    with pytest.raises(InputError, match=r"topic /loadcell.*wrench\.power.*lab map"):
        load([path])

"""CSV and Parquet: what is read, converted and restored, and the one line for each bad file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

pytest.importorskip("pyarrow")
from er_models.errors import ErError, InputError, MissingChannel
from er_records.load import fingerprint, load, read
from er_records.provenance import digest_bytes
from er_records.readers.columns import UNITS, split_header
from er_records.record import CHANNELS, Array, Record
from er_records.write import write_csv, write_parquet
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

N, DT = 600, 0.005


def columns(n: int = N) -> dict[str, Array]:
    """A clean measurement of n rows."""
    t = DT * np.arange(n)
    x = 5e-3 * np.sin(2 * np.pi * 2.0 * t)
    return {
        "t": t,
        "deflection": x,
        "deflection_velocity": np.gradient(x, DT),
        "duty": np.where(t < 1.0, 0.0, 0.2),
        "damper_force": 60.0 * np.gradient(x, DT) + 3.0,
    }


def table(path: Path, data: Mapping[str, Array], delimiter: str = ",") -> Path:
    """Write columns as a plain text table."""
    rows = np.column_stack(list(data.values()))
    lines = [delimiter.join(data)] + [delimiter.join(f"{v!r}" for v in r) for r in rows.tolist()]
    path.write_text("\n".join(lines) + "\n")
    return path


def message(path: Path, text: str | bytes, *more: str) -> str:
    """The one line a bad file gives; checks that it names the file and everything in `more`."""
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(InputError) as caught:
        load([path])
    line = str(caught.value)
    assert caught.value.exit_status == 2
    assert "\n" not in line
    assert "expected" in line
    assert "found" in line
    for part in (path.name, *more):
        assert part in line
    return line


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_a_plain_table_is_read_as_it_stands(tmp_path: Path, delimiter: str) -> None:
    data = columns()
    path = table(tmp_path / "run.csv", data, delimiter)
    (record,) = load([path])
    assert record.name == "run"
    assert record.complete
    assert record.notes == ()
    assert record.digest == digest_bytes(path.read_bytes())
    np.testing.assert_array_equal(record.t, data["t"])
    for name in data.keys() - {"t"}:
        np.testing.assert_array_equal(record.channels[name], data[name])


def test_decimal_commas_are_understood_with_semicolons(tmp_path: Path) -> None:
    path = table(tmp_path / "run.csv", columns(), ";")
    path.write_text(path.read_text().replace(".", ","))
    (record,) = load([path])
    np.testing.assert_array_equal(record.channels["damper_force"], columns()["damper_force"])
    assert any("decimal comma" in note for note in record.notes)


def test_the_decimal_sign_is_that_of_the_columns_that_are_read(tmp_path: Path) -> None:
    path = table(tmp_path / "run.csv", columns(), ";")
    head, *rows = path.read_text().splitlines()
    text = [f"{head};remark", *(f"{row};" for row in rows)]
    text[40] += "bump, left"
    path.write_text("\n".join(text) + "\n")
    (record,) = load([path])
    np.testing.assert_array_equal(record.channels["damper_force"], columns()["damper_force"])
    assert not any("decimal comma" in note for note in record.notes)
    wrong = "\n".join([*text[:50], text[50].replace(".", ",", 1), *text[51:]])
    message(path, wrong, "data row 50, column 't'", "a number with decimal point", "'0,245'")
    wrong = "\n".join([*text[:50], text[50].replace(".", "x", 1), *text[51:]]).replace(".", ",")
    message(path, wrong, "data row 50, column 't'", "a number with decimal comma", "'0x245'")
    message(path, wrong.replace("0x245", "0.245"), "column 't'", "decimal comma", "'0.245'")


def test_stated_units_are_converted_and_noted(tmp_path: Path) -> None:
    data = columns()
    own = {
        "t [ms]": 1e3 * data["t"],
        "deflection [mm]": 1e3 * data["deflection"],
        "damper_force (kN)": 1e-3 * data["damper_force"],
        "duty [%]": 100.0 * data["duty"],
        "temperature [degC]": np.linspace(21.0, 24.0, N),
    }
    (record,) = load([table(tmp_path / "run.csv", own)])
    for name in ("deflection", "damper_force", "duty"):
        np.testing.assert_allclose(record.channels[name], data[name], rtol=0, atol=1e-12)
    np.testing.assert_allclose(record.t, data["t"], atol=1e-12)
    np.testing.assert_allclose(
        record.channels["temperature"], np.linspace(21.0, 24.0, N), atol=1e-9
    )
    assert "deflection converted from mm to m" in record.notes
    assert any("0 degC" in note for note in record.notes)


@pytest.mark.parametrize(
    ("si", "unit", "factor"),
    [("m", "in", 0.3048 / 12.0), ("m/s", "in/s", 0.3048 / 12.0), ("m/s", "mm/s", 1e-3), ("N", "kgf", 9.80665),
     ("N", "lbf", 0.45359237 * 9.80665), ("m/s2", "g", 9.80665), ("Pa", "bar", 1e5), ("s", "min", 60.0)],
)  # fmt: skip
def test_units_have_the_factors_of_their_definitions(si: str, unit: str, factor: float) -> None:
    assert UNITS[si][unit] == pytest.approx(factor, rel=1e-12)


def test_a_names_file_beside_the_data_gives_other_headers_their_meaning(tmp_path: Path) -> None:
    data = columns()
    path = table(tmp_path / "rig.csv", {"Zeit": data["t"], "Weg": 1e3 * data["deflection"]})
    (tmp_path / "rig.csv.names.yaml").write_text("t: Zeit\ndeflection: Weg [mm]\n")
    (record,) = load([path])
    np.testing.assert_allclose(record.channels["deflection"], data["deflection"], atol=1e-15)
    (tmp_path / "rig.csv.names.yaml").write_text("t: Zeit\ndefelction: Weg\n")
    with pytest.raises(ErError, match="did you mean deflection"):
        load([path])
    (tmp_path / "rig.csv.names.yaml").write_text("t: Zeit\ndeflection: Hub\n")
    with pytest.raises(InputError, match="'Hub', found Zeit, Weg"):
        load([path])


def test_columns_that_are_no_channel_are_left_out_with_a_note(tmp_path: Path) -> None:
    data = {
        **columns(),
        "operator_id": np.zeros(N),
        "force_unified": np.ones(N),
        "force_own": np.ones(N),
    }
    (record,) = load([table(tmp_path / "run.csv", data)])
    assert "column 'operator_id' is not a channel and was left out" in record.notes
    assert not record.has("operator_id")
    assert record.has("force_unified")
    assert record.has("force_own")


def test_names_may_be_more_or_fewer_than_the_usual_row_has_cells(tmp_path: Path) -> None:
    """Events behind some rows, row numbers that no name stands over, and a delimiter at the end of each row."""
    data = columns()
    rows = [list(map(repr, row)) for row in np.column_stack(list(data.values())).tolist()]
    events = {0: ["start"], 200: ["pause"], 201: ["resume"], N - 1: ["pause", "stop"]}
    above = ["Header Size:  3", "Made: today, here"]
    texts = {
        "events": [*above, ",".join([*data, "Events"]), *(",".join(r + events.get(k, [])) for k, r in enumerate(rows))],
        "numbers": [",".join(data), *(",".join([str(k + 1), *r]) for k, r in enumerate(rows))],
        "ended": [*above, ",".join(data), *(",".join([*r, ""]) for r in rows)],
    }  # fmt: skip
    for name, lines in texts.items():
        path = tmp_path / f"{name}.csv"
        path.write_text("\n".join(lines) + "\n")
        (record,) = load([path])
        np.testing.assert_array_equal(record.t, data["t"], err_msg=name)
        for channel in data.keys() - {"t"}:
            np.testing.assert_array_equal(record.channels[channel], data[channel], err_msg=name)


def test_a_short_row_of_a_table_with_events_is_dropped_at_the_end_and_named_elsewhere(
    tmp_path: Path,
) -> None:
    data = columns()
    rows = [",".join(map(repr, row)) for row in np.column_stack(list(data.values())).tolist()]
    lines = [",".join([*data, "Events"]), rows[0] + ",start", *rows[1:]]
    path = tmp_path / "run.csv"
    path.write_text("\n".join(lines)[: -len(rows[-1]) + 8])
    (record,) = load([path])
    assert (len(record), record.complete) == (N - 1, False)
    lines[300] = rows[299].rpartition(",")[0]
    message(path, "\n".join(lines) + "\n", "data row 300", "cells")


def test_a_recorder_with_pauses_is_read_by_its_times_of_day(tmp_path: Path) -> None:
    """Rows `number, date and time, channels, event` below lines that tell of the recorder."""
    path = tmp_path / "raw.txt"
    rate, t = 200, np.concatenate([np.arange(400), 10_000 + np.arange(600)]) / 200.0
    lines = [
        "Header Size:  3",
        f"Sampling Rate:  {rate}",
        "Sample Number, Date/Time, CHANNEL0, CHANNEL1, Events",
    ]
    for k, at in enumerate(t):
        clock = (
            f"04/29/2022 11:59:{20 + at:06.3f} AM"
            if at < 39
            else f"04/29/2022 12:00:{at - 40:06.3f} PM"
        )
        event = {
            0: ", DAQ Start",
            399: ", DAQ Pause",
            400: ", DAQ Resume",
            999: ", DAQ Pause, DAQ Stop",
        }.get(k, "")
        x = np.sin(2 * np.pi * 2 * at)
        lines.append(
            f"{k + 1:10d},   {clock}, {3 * np.cos(2 * np.pi * 2 * at):.4f}, {x:.4f}{event}"
        )
    path.write_text("\n".join(lines) + "\n")
    names = {
        "t": "Date/Time",
        "deflection": {"from": "CHANNEL1", "scale": 0.01},
        "damper_force": "CHANNEL0",
    }
    first, second = load([path], names)
    assert (len(first), len(second)) == (400, 600)
    assert second.t[0] - first.t[0] == pytest.approx(50.0, abs=1e-6)
    assert first.channels["deflection"].max() == pytest.approx(0.01, rel=1e-3)
    parts = load([path], names | {"duty": {"value": [0.25, 1]}})
    assert [set(part.channels["duty"]) for part in parts] == [{0.25}, {1.0}]
    with pytest.raises(
        InputError, match=r"duty.value: expected 2 values, one for each part .* found 3"
    ):
        load([path], names | {"duty": {"value": [0, 0.25, 1]}})


def test_heads_of_measuring_programs_are_no_samples(tmp_path: Path) -> None:
    """LabVIEW's head holds numbers and a line of units; others draw a rule below names and units."""
    data = columns()
    t, x, force = (data[k] for k in ("t", "deflection", "damper_force"))
    rows = list(zip(t, 1e3 * x, force, strict=True))
    lvm = [
        "LabVIEW Measurement\t", "Separator\tTab", "***End_of_Header***\t", "\t", "Samples\t600\t600\t",
        "Date\t2024/03/12\t2024/03/12\t", "Time\t10:12:33,12\t10:12:33,12\t", "Y_Unit_Label\tmm\tN\t",
        "X0\t0,0E+0\t0,0E+0\t", "Delta_X\t0,005\t0,005\t", "***End_of_Header***\t\t\t",
        "X_Value\tWeg\tKraft\tComment",
        *(f"{a:.6f}\t{b:.9f}\t{c:.9f}\t".replace(".", ",") for a, b, c in rows),
    ]  # fmt: skip
    ruled = [
        "   Time        Weg        Kraft", "   [s]         [mm]        [N]", "  -----       -----       -----",
        *(f"{a:8.4f} {b:14.9f} {c:14.9f}" for a, b, c in rows),
    ]  # fmt: skip
    for name, lines, time in (("a.lvm", lvm, "X_Value"), ("b.txt", ruled, "Time")):
        (tmp_path / name).write_text("\n".join(lines) + "\n")
        (record,) = load(
            [tmp_path / name], {"t": time, "deflection": "Weg", "damper_force": "Kraft"}
        )
        np.testing.assert_allclose(record.t, t, atol=1e-9)
        np.testing.assert_allclose(record.channels["deflection"], x, atol=1e-11)
        np.testing.assert_allclose(record.channels["damper_force"], force, atol=1e-8)


@pytest.mark.parametrize("zone", ["", "Z", "+01:00", "-0530"])
def test_times_of_iso_8601_are_read_with_their_zone(tmp_path: Path, zone: str) -> None:
    path, t = tmp_path / "run.csv", 0.005 * np.arange(N)
    lines = [f"2026-11-30T23:59:{58 + s:06.3f}{zone},{s}" for s in t if s < 2.0]
    lines += [f"2026-12-01T00:00:{s - 2.0:06.3f}{zone},{s}" for s in t if s >= 2.0]
    path.write_text("\n".join(["timestamp,damper_force", *lines]) + "\n")
    (record,) = load([path], {"t": "timestamp"})
    np.testing.assert_allclose(record.t - record.t[0], t, atol=1e-6)


def test_bad_files_give_one_clear_line_each(tmp_path: Path) -> None:
    path = tmp_path / "bad.csv"
    rows = "".join(f"{0.005 * k},{1e-3 * k / N},0.1\n" for k in range(N))
    message(path, "", "empty")
    message(path, "# only a comment\n", "header")
    message(path, b"t,deflection\n\xff\xfe,1\n", "UTF-8")
    message(path, "0.0,1.0\n0.005,1.1\n", "row 1", "header")
    message(path, "time,deflection,duty\n" + rows, "did you mean 't'?")
    message(path, "t,deflektion,duty\n" + rows, "'deflektion' (did you mean 'deflection'?)")
    message(path, "t,force,duty\n" + rows, "did you mean 'damper_force'?")
    message(
        path, "t,deflection_mm,duty\n" + rows, "'deflection_mm' (did you mean 'deflection [mm]'?)"
    )
    for unit in ("N", "kN"):
        hint = f"'force_{unit}' (did you mean 'damper_force [{unit}]'?)"
        message(path, f"t,deflection,force_{unit}\n" + rows, "'damper_force'", hint)
    message(path, "time_ms,deflection,duty\n" + rows, "'time_ms' (did you mean 't [ms]'?)")
    message(path, "t,foo,bar\n" + rows, "columns", "deflection")
    message(path, "t,deflection,deflection\n" + rows, "'deflection'", "found 2")
    message(path, "t,deflection [furlong],duty\n" + rows, "furlong", "mm")
    message(
        path, "t,deflection,duty\n" + rows + "3.0,oops,0.1\n", "row 601", "'deflection'", "'oops'"
    )
    message(path, "t,deflection,duty\n0,1\n" + rows, "row 1", "3 cells", "found 2")
    message(path, "t,deflection,duty\n", "no rows")


def test_an_unsorted_or_doubled_time_names_its_row(tmp_path: Path) -> None:
    data = columns()
    data["t"][[300, 301]] = data["t"][[301, 300]]
    text = table(tmp_path / "t.csv", data).read_text()
    message(tmp_path / "t.csv", text, "row 302", "not sorted")
    data = columns()
    data["t"][300] = data["t"][299]
    text = table(tmp_path / "t.csv", data).read_text()
    message(tmp_path / "t.csv", text, "row 301", "two different rows")
    data["t"][300] = np.nan
    text = table(tmp_path / "t.csv", data).read_text()
    message(tmp_path / "t.csv", text, "row 301", "nan")


@pytest.mark.parametrize(
    ("channel", "factor", "hint"),
    [
        ("deflection", 1e3, "looks like mm"),
        ("deflection_velocity", 1e3, "looks like mm/s"),
        ("duty", 100.0, "looks like percent"),
        ("t", 1e3, "looks like ms"),
    ],
)
def test_wrong_units_are_named_by_what_they_look_like(
    tmp_path: Path, channel: str, factor: float, hint: str
) -> None:
    data = columns()
    data[channel] = factor * data[channel]
    text = table(tmp_path / "u.csv", data).read_text()
    message(tmp_path / "u.csv", text, channel, hint)


def test_names_of_ones_own_are_asked_for_where_none_are_given(tmp_path: Path) -> None:
    own = {"Zeit" if k == "t" else k: v for k, v in columns().items()}
    text = table(tmp_path / "rig.csv", own).read_text()
    message(tmp_path / "rig.csv", text, "found Zeit", "./er lab map ", "rig.csv")


def test_a_negative_duty_and_an_infinite_force_are_refused(tmp_path: Path) -> None:
    data = columns()
    data["duty"][5] = -0.01
    message(tmp_path / "u.csv", table(tmp_path / "u.csv", data).read_text(), "duty", "0..1")
    data = columns()
    data["damper_force"][5] = np.inf
    text = table(tmp_path / "u.csv", data).read_text()
    message(tmp_path / "u.csv", text, "damper_force, row 6", "infinity")


def test_too_short_a_record_is_refused(tmp_path: Path) -> None:
    for data in (columns(199), {k: v[::40] for k, v in columns(6000).items()}):
        text = table(tmp_path / "s.csv", data).read_text()
        message(tmp_path / "s.csv", text, "length", "2 s and 200 samples")
    (record,) = load([table(tmp_path / "s.csv", columns(400))])
    assert len(record) == 400


def test_a_line_cut_off_at_the_end_is_dropped_and_the_record_marked(tmp_path: Path) -> None:
    path = table(tmp_path / "cut.csv", columns())
    path.write_text(path.read_text()[:-20].rsplit(",", 1)[0])
    (record,) = load([path])
    assert len(record) == N - 1
    assert not record.complete
    assert any("cut off" in note for note in record.notes)


def test_paths_that_are_no_data_are_named(tmp_path: Path) -> None:
    (tmp_path / "a.docx").write_text("x")
    for path, part in (
        (tmp_path / "none.csv", "nothing there"),
        (tmp_path / "a.docx", "'.docx'"),
        (tmp_path, "a.docx"),
    ):
        with pytest.raises(InputError, match="expected") as caught:
            load([path])
        assert part in str(caught.value)
        assert path.name in str(caught.value)
    with pytest.raises(InputError, match="at least one file"):
        load([])


def test_a_folder_gives_its_files_sorted_and_equal_names_are_told_apart(
    tmp_path: Path,
) -> None:
    for n, name in ((N + 1, "b.csv"), (N, "a.csv")):
        table(tmp_path / name, columns(n))
    (tmp_path / "SOURCE.txt").write_text("where from")
    other = tmp_path / "other"
    other.mkdir()
    table(other / "a.csv", columns(N + 2))
    (tmp_path / ".hidden").mkdir()
    table(tmp_path / ".hidden" / "c.csv", columns())
    assert [r.name for r in load([tmp_path])] == [f"{tmp_path.name}/a", "b", "other/a"]
    records = load([tmp_path / "a.csv", other / "a.csv"])
    assert [r.name for r in records] == [f"{tmp_path.name}/a", "other/a"]
    namesake = tmp_path / ".hidden" / "other"
    namesake.mkdir()
    records = load([other / "a.csv", table(namesake / "a.csv", columns(N + 3))])
    assert len({r.name for r in records}) == 2


def test_a_table_of_something_else_in_a_folder_is_named_with_the_way_out(tmp_path: Path) -> None:
    table(tmp_path / "run.csv", columns())
    text = "key,value\nrig,7\n"
    (tmp_path / "settings.csv").write_text(text)
    with pytest.raises(InputError, match=r"settings.csv: columns: .* name the files of"):
        load([tmp_path])


def test_a_needed_channel_that_is_absent_has_exit_status_4(tmp_path: Path) -> None:
    (record,) = load([table(tmp_path / "run.csv", columns())])
    with pytest.raises(MissingChannel, match=r"road.*to predict the motion.*deflection") as caught:
        record.need("road", "to predict the motion")
    assert caught.value.exit_status == 4
    assert record.need("duty", "to predict the force") is record.channels["duty"]


def test_times_since_1970_in_nanoseconds_are_read(tmp_path: Path) -> None:
    begin, n = 1_700_000_000_123_456_789, 600
    t = begin + 5_000_000 * np.arange(n)
    names = {
        "t [ns]": pa.array(t),
        "deflection [um]": pa.array(np.arange(n)),
        "damper_force": pa.array(np.ones(n)),
    }
    pq.write_table(pa.table(names), tmp_path / "run.parquet")
    (record,) = load([tmp_path / "run.parquet"])
    assert record.dt == pytest.approx(0.005, rel=1e-3)
    assert record.channels["deflection"][-1] == pytest.approx((n - 1) * 1e-6)


def test_damaged_parquet_is_named(tmp_path: Path) -> None:
    path = tmp_path / "run.parquet"
    write_parquet(load([table(tmp_path / "run.csv", columns())])[0], path)
    data = path.read_bytes()
    message(path, data[: len(data) // 2], "Parquet")
    message(path, b"", "empty")
    pq.write_table(pa.table({"t": [0.0, 1.0], "deflection": ["a", "b"]}), path)
    message(path, path.read_bytes(), "'deflection'", "string")


def values(n: int) -> st.SearchStrategy[Array]:
    """Deflections of any size a suspension can have, missing now and then."""
    finite = st.floats(-1.0, 1.0, allow_subnormal=True)
    return arrays(np.float64, n, elements=st.one_of(finite, st.just(float("nan"))))


@settings(max_examples=40, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    samples=st.integers(2, 30).flatmap(lambda n: st.tuples(values(n), values(n), values(n))),
    note=st.text(max_size=40),
    form=st.sampled_from(["csv", "parquet"]),
)
def test_what_is_written_is_read_back_to_the_last_bit(
    tmp_path: Path, samples: tuple[Array, Array, Array], note: str, form: str
) -> None:
    steps, x, estimate = samples
    record = Record(
        "run",
        np.cumsum(1e-3 + np.abs(np.nan_to_num(steps))),
        {"deflection": x, "damper_force": 100.0 * x[::-1], "force_unified": estimate},
        (note, "second"),
        False,
        "somewhere else",
        "d1gest",
        {"duty": "1 = 1.0 A"},
        ("deflection",),
        "MIT",
    )
    path = tmp_path / f"run.{form}"
    (write_csv if form == "csv" else write_parquet)(record, path)
    (back,) = read(path)
    for name in ("name", "notes", "complete", "source", "digest", "scales", "derived", "licence"):
        assert getattr(back, name) == getattr(record, name)
    np.testing.assert_array_equal(back.t, record.t)
    assert list(back.channels) == list(record.channels)
    for name, samples_of in record.channels.items():
        np.testing.assert_array_equal(back.channels[name], samples_of)
    assert fingerprint([back]) == fingerprint([record])


def test_a_changed_copy_no_longer_passes_for_the_original(tmp_path: Path) -> None:
    (record,) = load([table(tmp_path / "run.csv", columns())])
    write_csv(record, tmp_path / "copy.csv")
    lines = (tmp_path / "copy.csv").read_text().splitlines(keepends=True)
    cells = lines[50].split(",")
    lines[50] = ",".join([cells[0], "0.01", *cells[2:]])
    (tmp_path / "copy.csv").write_text("".join(lines))
    (changed,) = load([tmp_path / "copy.csv"])
    assert changed.channels["deflection"][48] == 0.01
    assert any("were changed" in note for note in changed.notes)
    assert fingerprint([changed]) != fingerprint([record])
    (tmp_path / "copy.csv").write_text("# er_record {broken\n" + "".join(lines[1:]))
    with pytest.raises(InputError, match="er_record"):
        load([tmp_path / "copy.csv"])


def test_a_failed_write_leaves_the_old_file(tmp_path: Path) -> None:
    (record,) = load([table(tmp_path / "run.csv", columns())])
    path = tmp_path / "out.csv"
    path.write_text("precious")
    broken = Record("b", record.t, dict(record.channels))
    object.__setattr__(broken, "channels", {"deflection": record.t[:5]})
    with pytest.raises(ValueError, match="dimension"):
        write_csv(broken, path)
    assert path.read_text() == "precious"
    assert [p.name for p in tmp_path.iterdir() if p.name.endswith(".part")] == []
    # a hard link still shows the old file, because the new one took its place and not its blocks
    (tmp_path / "link").hardlink_to(path)
    write_csv(record, path)
    assert (tmp_path / "link").read_text() == "precious"
    assert path.read_text().startswith("# er_record")


def test_every_channel_of_the_contract_has_a_unit() -> None:
    assert set(CHANNELS) == {
        "road",
        "deflection",
        "deflection_velocity",
        "duty",
        "damper_force",
        "sprung_acceleration",
        "unsprung_acceleration",
        "temperature",
        "actuator_force",
        "sprung_displacement",
        "unsprung_displacement",
    }


@pytest.mark.parametrize(
    ("cell", "name", "unit"),
    [
        ("Kraft / kN", "Kraft", "kN"),
        ("Weg/mm", "Weg", "mm"),
        ("Kraft in kN", "Kraft", "kN"),
        ("v / m/s", "v", "m/s"),
        ("Kolbenweg [mm]", "Kolbenweg", "mm"),
        ("v (m/s)", "v", "m/s"),
        ("/loadcell.wrench.force.z", "/loadcell.wrench.force.z", ""),
        ("Messung/F", "Messung/F", ""),
        ("Messung/Kraft", "Messung/Kraft", ""),
        ("left in front", "left in front", ""),
    ],
)
def test_a_unit_stands_in_brackets_or_under_a_stroke(cell: str, name: str, unit: str) -> None:
    assert split_header(cell) == (name, unit)

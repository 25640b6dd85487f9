"""Importers of measured data sets: on files made here, and on the sets where they are."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from er_models.errors import ErError, InputError
from er_records.load import fingerprint, load
from er_records.record import Array, Record
from er_studies.importers import mts, shaking_table
from er_studies.importers.checks import dissipated
from er_studies.importers.command import KINDS, app
from er_studies.importers.data_sets import IMPORTERS, import_data, part_of
from scipy.io import savemat
from typer.testing import CliRunner

RUNNER = CliRunner()


def shared_data() -> Path | None:
    """Folder of the measured data: ER_SHARED_DATA, or shared/data beside the repository."""
    if "ER_SHARED_DATA" in os.environ:
        return Path(os.environ["ER_SHARED_DATA"])
    beside = (parent.parent / "shared" / "data" for parent in Path(__file__).resolve().parents)
    return next((folder for folder in beside if folder.is_dir()), None)


def folder(name: str) -> Path:
    """Folder of one measured set; skips the test, and says so, where it is not there."""
    shared = shared_data()
    if shared is None or not (shared / name).is_dir():
        pytest.skip(f"no measured data '{name}': set ER_SHARED_DATA to the folder that holds it")
    return shared / name


def mts_text(forces: tuple[float, ...], rate: int, n: int = 3000, sign: float = 1.0) -> str:
    """A data acquisition file with one run for each force amplitude [N]."""
    t = np.arange(n) / rate
    x, v = np.sin(2 * np.pi * t), np.cos(2 * np.pi * t)
    lines = ["Header Size:  7", "Version:  2", f"Sampling Interval:  {1 / rate}"]
    lines += [f"Sampling Rate:  {rate}", f"Sample Count:  {n * len(forces)}"]
    lines += ["Device Serial Number:  0", "Sample Number, Date/Time, CHANNEL0, CHANNEL1, Events"]
    number = 0
    for run, force in enumerate(forces):
        for k in range(n):
            number += 1
            load_cell, place = sign * (force * v[k] + 40.0) / mts.NEWTONS_PER_UNIT, x[k] - 3.0
            first, second = (load_cell, place) if rate == 200 else (place, load_cell)
            event = ", DAQ Resume" if k == 0 and run else ", DAQ Pause" if k == n - 1 else ""
            lines.append(f"{number:10d},   05/13/2022 05:00:29.714 PM, {first}, {second}{event}")
    return "\n".join(lines) + "\n"


FORCES = (50.0, 100.0, 200.0, 300.0, 400.0)


@pytest.mark.parametrize("rate", [200, 1000])
def test_an_mts_file_gives_five_runs_in_contract_units(tmp_path: Path, rate: int) -> None:
    path = tmp_path / "ME10mm1Hz.txt"
    path.write_text(mts_text(FORCES, rate))
    records = import_data("mts", path)
    assert [r.name for r in records] == [
        f"ME10mm1Hz-{c}A" for c in ("0", "0.25", "0.5", "0.75", "1")
    ]
    for record, current, force in zip(records, mts.CURRENTS, FORCES, strict=True):
        assert record.dt == pytest.approx(0.005)
        assert record.complete
        assert record.scales == {"duty": "1 = 1 A"}
        np.testing.assert_array_equal(record.channels["duty"], current)
        t = record.t[20:-20]
        x, f = record.channels["deflection"][20:-20], record.channels["damper_force"][20:-20]
        np.testing.assert_allclose(x, -0.010 * np.sin(2 * np.pi * t), atol=2e-5)
        np.testing.assert_allclose(f, -force * np.cos(2 * np.pi * t) - 40.0, atol=0.002 * force)
        assert dissipated(record.channels["deflection"], record.channels["damper_force"]) > 0.0


def test_the_anti_alias_filter_takes_out_what_200_hz_cannot_show(tmp_path: Path) -> None:
    path = tmp_path / "ME10mm1Hz.txt"
    path.write_text(mts_text(FORCES, 1000))
    clean_run = mts.read(path)[4].channels["damper_force"]
    lines = path.read_text().splitlines()
    for i, line in enumerate(lines[7:]):
        cells = line.split(",")
        hum = 0.2 * np.sin(2 * np.pi * 190.0 * i / 1000.0)
        cells[3] = f" {float(cells[3]) + hum}"
        lines[7 + i] = ",".join(cells)
    path.write_text("\n".join(lines) + "\n")
    hummed = mts.read(path)[4].channels["damper_force"]
    left = float(np.std((hummed - clean_run)[50:-50])) / (0.2 * mts.NEWTONS_PER_UNIT / np.sqrt(2))
    assert left < 0.01
    full = mts.read(path, rate=1000.0)[4]
    assert len(full) == 3000


def test_mts_files_that_are_not_as_described_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "ME10mm1Hz.txt"
    for text, part in (
        (mts_text(FORCES, 200, sign=-1.0), "takes energy out"),
        (mts_text(FORCES[::-1], 200), "rise with the current"),
        (mts_text(FORCES[:3], 200), "5 runs"),
        (mts_text(FORCES, 200).replace("Sampling Rate:  200", "Sampling Rate:  often"), "line 4"),
        (mts_text(FORCES, 200).replace("\n        10,", "\n        11,"), "line 17"),
        ("nothing", "line 1"),
        ("", "line 1"),
    ):
        path.write_text(text)
        with pytest.raises(InputError, match="expected") as caught:
            import_data("mts", path)
        assert part in str(caught.value)
        assert "\n" not in str(caught.value)
    path.rename(tmp_path / "other.txt").write_text(mts_text(FORCES, 200))
    with pytest.raises(InputError, match="ME<amplitude>"):
        import_data("mts", tmp_path / "other.txt")


def test_the_parts_of_the_mts_set() -> None:
    for stem in mts.TRAINING:
        assert mts.split(f"{stem}-0.25A") == mts.split(f"{stem}.txt") == "train"
    assert mts.split("ME10mm2Hz-1A") == "held_out_sine"
    assert (
        mts.split("15Hz-0A")
        == mts.split("15Hz1A")
        == mts.split("15Hz0x5A.txt")
        == "held_out_sweep"
    )
    with pytest.raises(ErError, match="unknown run"):
        mts.split("something")


@pytest.mark.parametrize(
    ("name", "amperes"), [("15Hz0x5A", 0.5), ("15Hz0.5A", 0.5), ("15Hz1A", 1.0)]
)
def test_a_sweep_is_of_the_current_that_its_name_says(
    name: str, amperes: float, tmp_path: Path
) -> None:
    (tmp_path / f"{name}.txt").write_text(mts_text((100.0,), 1000))
    (record,) = import_data("mts", tmp_path / f"{name}.txt")
    assert record.name == f"15Hz-{amperes:g}A"
    assert set(record.channels["duty"]) == {amperes}


def save_run(folder: Path, name: str, plateau: float) -> None:
    """A shaking-table file whose force has the given yield [N]."""
    t = 0.01 * np.arange(1501)
    x = 12.0 * np.sin(2 * np.pi * t)
    v = 12.0 * 2 * np.pi * np.cos(2 * np.pi * t)
    force = plateau * np.tanh(v / 2.0) + 0.1 * v + 130.0
    variables = {"dist": x, "forc": force, "Tout": t}
    savemat(folder / f"{name}.mat", {k: v.reshape(-1, 1) for k, v in variables.items()})


def test_an_unstated_voltage_is_inferred_and_marked_as_such(tmp_path: Path) -> None:
    for name, plateau in (("ensaio1.1", 60.0), ("ensaio.vali.1", 210.0), ("ensaio10.2", 135.0)):
        save_run(tmp_path, name, plateau)
    save_run(tmp_path, "ensaio.A.1", 700.0)
    records = {r.name: r for r in import_data("shaking_table", tmp_path)}
    assert list(records) == ["ensaio1.1", "ensaio10.2", "ensaio.A.1", "ensaio.vali.1"]
    assert records["ensaio.A.1"].channels["duty"][0] == 1.0
    assert records["ensaio.vali.1"].channels["duty"][0] == pytest.approx(0.8712 / 3.212)
    inferred = records["ensaio10.2"]
    assert inferred.channels["duty"][0] == pytest.approx(0.5 * 0.8712 / 3.212, rel=1e-3)
    assert "duty" in inferred.derived
    assert any("inferred from the force" in note for note in inferred.notes)
    force = records["ensaio1.1"].channels["damper_force"]
    assert float(force.mean()) == pytest.approx(-130.0, abs=2.0)
    (alone,) = import_data("shaking_table", tmp_path / "ensaio10.2.mat")
    assert not alone.has("duty")


def test_shaking_table_files_that_are_not_as_described_are_refused(tmp_path: Path) -> None:
    savemat(tmp_path / "ensaio1.1.mat", {"other": np.zeros(3)})
    with pytest.raises(InputError, match=r"dist, forc, Tout, found no dist"):
        import_data("shaking_table", tmp_path)
    (tmp_path / "ensaio1.1.mat").write_bytes(b"no matlab file")
    with pytest.raises(InputError, match="MATLAB") as caught:
        import_data("shaking_table", tmp_path)
    assert "\n" not in str(caught.value)
    (tmp_path / "ensaio1.1.mat").rename(tmp_path / "MyOutput.mat")
    with pytest.raises(InputError, match=r"MyOutput.mat: name"):
        import_data("shaking_table", tmp_path)


def seal_rows(n: int = 3000) -> Array:
    """A seal friction file: tare, then strokes with a pause of the logger in the middle."""
    t = np.concatenate(([0.0], 500.0 + 10.0 * np.arange(n)))
    t[n // 2 :] += 700.0
    x = 20.0 - 20.0 * np.cos(2e-3 * t / 2.0)
    v = np.gradient(x, t)
    force = 150.0 + 8.0 * np.sign(v)
    pressure = np.full(t.size, 3.01)
    volts = np.ones((t.size, 3))
    return np.column_stack([t, volts, x, pressure, force])


def test_a_seal_file_is_split_at_its_pauses(tmp_path: Path) -> None:
    path = tmp_path / "O-ring257_3bar.csv"
    np.savetxt(path, seal_rows(), delimiter="\t", fmt="%.3f")
    records = import_data("piston_seal", path)
    assert [r.name for r in records] == ["O-ring257_3bar#1", "O-ring257_3bar#2"]
    for record in records:
        assert record.complete
        assert record.t[0] > 0.4
        assert record.channels["duty"][0] == pytest.approx(3.01 / 8.0)
        np.testing.assert_allclose(record.channels["pressure"], 3.01e5)
        assert float(record.channels["damper_force"].mean()) == pytest.approx(-150.0, abs=8.0)
    for text, part in (("1\t2\n3\t4\n", "columns"), ("a\tb\n", "numbers")):
        path.write_text(text)
        with pytest.raises(InputError, match=part):
            import_data("piston_seal", path)
    path.rename(tmp_path / "O-ring.csv")
    with pytest.raises(InputError, match="bar"):
        import_data("piston_seal", tmp_path / "O-ring.csv")


@pytest.mark.parametrize("form", ["parquet", "csv"])
def test_the_command_writes_what_import_data_returns(tmp_path: Path, form: str) -> None:
    source = tmp_path / "set"
    source.mkdir()
    for name in ("ME2mm5Hz", "ME10mm2Hz"):
        (source / f"{name}.txt").write_text(mts_text(FORCES, 200))
    (source / "LICENSE").write_text("MIT")
    out = tmp_path / "out"
    result = RUNNER.invoke(app, ["mts", str(source), "--out", str(out), "--format", form])
    assert result.exit_code == 0, result.output
    assert "held_out_sine: 5 records" in result.output
    assert (out / "LICENSE").read_text() == "MIT"
    written = {r.name: r for part in ("train", "held_out_sine") for r in load([out / part])}
    for record in import_data("mts", source):
        back = written[record.name]
        assert fingerprint([back]) == fingerprint([record])
        assert (back.notes, back.licence) == (record.notes, record.licence)
        assert (out / part_of("mts", record) / f"{record.name}.{form}").exists()
    assert not list(out.rglob("*.part"))


def test_the_command_says_in_one_line_what_is_wrong(tmp_path: Path) -> None:
    out = str(tmp_path / "out")
    for kind, source, part in (
        ("mtz", tmp_path, "did you mean mts?"),
        ("mts", tmp_path / "none", "nothing there"),
        ("mts", tmp_path, "files *Hz*.txt"),
        ("shaking_table", tmp_path, "ensaio*.mat"),
    ):
        result = RUNNER.invoke(app, [kind, str(source), "--out", out])
        assert result.exit_code == 2
        assert part in result.stderr
        assert len(result.stderr.strip().splitlines()) == 1
    assert not (tmp_path / "out").exists()


def nrmse(records: list[Record], weights: Array | None = None) -> tuple[float, Array]:
    """Fit of bias + k x + c v to the force (or given weights): rms error over deviation."""
    force = np.concatenate([r.channels["damper_force"] for r in records])
    x = np.concatenate([r.channels["deflection"] for r in records])
    v = np.concatenate([r.channels["deflection_velocity"] for r in records])
    terms = np.column_stack((np.ones_like(x), x, v))
    if weights is None:
        weights = np.asarray(np.linalg.lstsq(terms, force, rcond=None)[0])
    return float(np.std(force - terms @ weights) / np.std(force)), weights


def test_the_measured_mts_runs() -> None:
    records = import_data("mts", folder("mr_damper_mts"))
    assert len(records) == 27
    parts: dict[str, list[Record]] = {}
    for record in records:
        parts.setdefault(part_of("mts", record), []).append(record)
        assert record.dt == pytest.approx(0.005)
        assert record.complete
        assert dissipated(record.channels["deflection"], record.channels["damper_force"]) > 0.0
    assert {part: len(own) for part, own in parts.items()} == {
        "train": 20,
        "held_out_sine": 5,
        "held_out_sweep": 2,
    }
    # the README of the data gives 0.59 and 0.64 for this fit on its own cut of the runs
    error, weights = nrmse(parts["train"])
    assert error == pytest.approx(0.59, abs=0.05)
    assert nrmse(parts["held_out_sweep"], weights)[0] == pytest.approx(0.64, abs=0.1)


def test_the_measured_gas_force_pushes_the_mts_damper_out() -> None:
    run = next(
        r for r in import_data("mts", folder("mr_damper_mts")) if r.name == "ME25mm0x25Hz-0A"
    )
    x, v, force = (
        run.channels[name] for name in ("deflection", "deflection_velocity", "damper_force")
    )
    moving = np.abs(v) > 3e-3

    def middle(low: float, high: float) -> float:
        inside = moving & (x > low) & (x < high)
        forth, back = force[inside & (v > 0)], force[inside & (v < 0)]
        return 0.5 * float(forth.mean() + back.mean())

    compressed, extended = middle(-0.023, -0.015), middle(0.015, 0.023)
    assert compressed < extended < 0.0


def test_the_measured_shaking_table_runs() -> None:
    records = import_data("shaking_table", folder("mr_damper_shaking_table"))
    assert len(records) == 50
    assert all(r.dt == pytest.approx(0.01) for r in records)
    inferred = {r.name: float(r.channels["duty"][0]) for r in records if "duty" in r.derived}
    assert len(inferred) == 13
    for name, duty in inferred.items():
        low, high = (1.98, 3.212) if ".A." in name else (0.5, 1.1)
        assert low < duty * shaking_table.FULL_VOLTAGE < high
    # inferring a voltage that is stated must give it back, or inferring the others means nothing
    files = sorted(folder("mr_damper_shaking_table").glob("ensaio*.mat"))
    known = {f: shaking_table.stated_voltage(f) for f in files}
    plateaus = {f: shaking_table.plateau(*shaking_table._variables(f)) for f in files}
    for left_out, voltage in known.items():
        if voltage is None:
            continue
        others = [(v, plateaus[f]) for f, v in known.items() if v is not None and f != left_out]
        guess = shaking_table.infer_voltage(plateaus[left_out], others)
        assert guess == pytest.approx(voltage, abs=0.15)


def test_the_measured_seal_runs() -> None:
    records = import_data("piston_seal", folder("piston_seal_friction"))
    assert len(records) == 14
    friction = {}
    for record in records:
        assert record.dt == pytest.approx(0.01)
        assert float(np.ptp(np.diff(record.t))) < 1e-6
        v, force = record.channels["deflection_velocity"], record.channels["damper_force"]
        inner = np.abs(record.channels["deflection"]) < 0.01
        forth, back = force[inner & (v > 2e-3)], force[inner & (v < -2e-3)]
        if len(record) > 3000:
            friction[record.name] = 0.5 * float(np.median(forth) - np.median(back))
    # SOURCE.txt: half the difference of the two directions is 6.5, 8.0, 9.4 and 11.5 N
    rings = {name.split("#")[0]: value for name, value in friction.items() if "O-ring" in name}
    for name, value in {"1bar": 6.5, "3bar": 8.0, "5bar": 9.4, "7bar": 11.5}.items():
        assert rings[f"O-ring257_{name}"] == pytest.approx(value, rel=0.12)


def test_every_importer_can_be_asked_for() -> None:
    assert tuple(IMPORTERS) == KINDS

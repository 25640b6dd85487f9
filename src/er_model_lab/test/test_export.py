"""What is taken to other programs: series of every format read again, tables of force, C code and units."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("pyarrow")
pytest.importorskip("asammdf")
from asammdf import MDF
from er_model_lab.cli.app import app
from er_models.export.force_table import force_table
from er_models.files import load_model
from er_models.model import Model
from er_models.prediction import motion, predict
from er_models.shipped import names
from lab_help import DT, GUO, imposed
from scipy.io import loadmat
from typer.testing import CliRunner

import er_model_lab as lab

FORCES = ("damper_force", "force_predicted", "force_residual")


def truth() -> Model:
    """The Guo damper with friction."""
    return load_model(GUO).with_effect("coulomb_friction", {"F_c": 1.0, "v_0": 0.003})


def write_run(path: Path, seed: int, n: int = 800) -> Path:
    """A record whose force has no noise, from 3 s on."""
    x, v, a, u = imposed(np.random.default_rng(seed), n)
    force = predict(truth(), motion(DT, x, v, u, a))
    rows = np.column_stack([3.0 + DT * np.arange(n), x, v, u, force, a, 0.0 * a])
    head = "t,deflection,deflection_velocity,duty,damper_force,sprung_acceleration,unsprung_acceleration"
    np.savetxt(path, rows, delimiter=",", header=head, comments="", fmt="%.17g")
    return path


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Two records."""
    folder = tmp_path_factory.mktemp("runs")
    return [write_run(folder / f"run{seed}.csv", seed) for seed in (1, 2)]


def call(*words: Any) -> Any:
    """A command of the lab."""
    return CliRunner().invoke(app, ["export", *map(str, words)])


def again(path: Path) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Columns of a file and their units, as the program that reads such files gives them."""
    if path.suffix == ".mat":
        found = loadmat(path)
        units = {name: str(found["units"][name][0, 0][0]) for name in found["units"].dtype.names}
        return {name: found[name][:, 0] for name in units}, units
    if path.suffix == ".mf4":
        with MDF(path) as mdf:
            signals = [mdf.get(name) for name in mdf.channels_db if name not in ("time", "t")]
            columns = {"t": signals[0].timestamps} | {s.name: s.samples for s in signals}
            return columns, {"t": "s"} | {s.name: s.unit for s in signals}
    (record,) = lab.load(path).records
    columns = {"t": record.t, **record.channels}
    if path.suffix == ".csv":
        head = path.read_text().splitlines()[0].split(",")
        return columns, {c.split(" [")[0]: c.split(" [")[1][:-1] for c in head}
    import pyarrow.parquet as pq

    return columns, {f.name: f.metadata[b"unit"].decode() for f in pq.read_schema(path)}


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".mat", ".mf4"])
def test_a_series_is_read_again_whole(suffix: str, runs: list[Path], tmp_path: Path) -> None:
    result = lab.export(truth(), lab.load(runs[0]), series=tmp_path / f"out{suffix}")
    columns, units = again(tmp_path / f"out{suffix}")
    shares = {f"force_{name}" for name in truth().effects}
    inputs = ("deflection", "deflection_velocity", "deflection_acceleration", "duty")
    assert set(columns) == {"t", *inputs, *FORCES, *shares}
    assert units == {"t": "s", "deflection": "m", "deflection_velocity": "m/s", "deflection_acceleration": "m/s2",
                     "duty": "1"} | dict.fromkeys((*FORCES, *shares), "N")  # fmt: skip
    (given,) = lab.load(runs[0]).records
    np.testing.assert_array_equal(columns["t"], given.t)
    np.testing.assert_array_equal(columns["damper_force"], given.channels["damper_force"])
    measured, predicted, residual = (columns[name] for name in FORCES)
    np.testing.assert_allclose(measured - predicted, residual, atol=1e-12)
    (loaded,) = lab.load(tmp_path / f"out{suffix}").records
    assert loaded.notes == ()
    np.testing.assert_array_equal(loaded.channels["force_residual"], columns["force_residual"])
    assert result.to_dict()["series"][0]["rmse"] == pytest.approx(np.sqrt(np.mean(residual**2)))


def test_a_share_is_what_is_lost_without_the_effect(runs: list[Path], tmp_path: Path) -> None:
    lab.export(truth(), lab.load(runs[0]), series=tmp_path / "out.csv")
    columns, _ = again(tmp_path / "out.csv")
    v = columns["deflection_velocity"]
    np.testing.assert_allclose(columns["force_coulomb_friction"], np.tanh(v / 0.003), atol=1e-9)
    m, passive = truth(), columns["force_passive"]
    expected = m.value("passive", "k0") * columns["deflection"] + m.value("passive", "c0") * v
    np.testing.assert_allclose(passive, expected, atol=1e-9)


def test_each_record_gets_its_file(runs: list[Path], tmp_path: Path) -> None:
    result = call(
        *runs, "--model", GUO, "--series", tmp_path / "out.parquet", "--json", tmp_path / "r.json"
    )
    assert result.exit_code == 0, result.output
    made = json.loads((tmp_path / "r.json").read_text())
    assert [Path(f).name for f in made["files"]] == ["out_run1.parquet", "out_run2.parquet"]
    for series, run in zip(made["series"], runs, strict=True):
        np.testing.assert_array_equal(
            again(Path(series["file"]))[0]["t"], lab.load(run).records[0].t
        )
        assert set(series["shares"]) == set(load_model(GUO).effects)


def test_a_table_holds_the_force_at_the_middle_of_the_stroke(tmp_path: Path) -> None:
    assert call("--model", GUO, "--lut", tmp_path / "lut.csv").exit_code == 0
    head, *rows = (tmp_path / "lut.csv").read_text().splitlines()
    assert head.split(",")[:3] == [
        "velocity [m/s]",
        "force at duty 0 [N]",
        "force at duty 0.05 [N]",
    ]
    table = np.array([row.split(",") for row in rows], float)
    m = load_model(GUO)
    assert (table[0, 0], table[-1, 0]) == (-m.rig["velocity_max"], m.rig["velocity_max"])
    np.testing.assert_allclose(table[:, 1], m.value("passive", "c0") * table[:, 0], rtol=1e-9)
    slow = table[np.isclose(table[:, 0], 0.0135)][0]
    assert slow[-1] - slow[1] == pytest.approx(0.3 * m.value("guo_yield", "f_c"), rel=1e-3)


@pytest.mark.parametrize("name", names("dampers", "vehicles"))
def test_every_shipped_model_has_a_table(name: str) -> None:
    table = force_table(load_model(name))
    assert table.force.shape == (table.velocity.size, table.duty.size)
    assert np.all(np.diff(table.velocity) > 0.0)
    assert np.isfinite(table.force).all()
    assert np.all(np.diff(table.force[:, -1]) > 0.0)


def test_a_damper_without_duty_and_sensors_that_lie(tmp_path: Path) -> None:
    plain = load_model(GUO).without_effect("guo_yield").without_effect("response")
    assert force_table(plain).duty.tolist() == [0.0]
    lying = plain.with_effect("deflection_zero", {"x_0": 0.002}).with_effect(
        "force_gain", {"g_F": 2.0}
    )
    np.testing.assert_array_equal(force_table(lying).force, force_table(plain).force)
    assert "force_gain" in c_of(lying, tmp_path)
    assert "force_gain" not in c_of(lying, tmp_path, sensors=False)


def c_of(model: Model, folder: Path, *, sensors: bool = True) -> str:
    """The C code of a model."""
    return lab.export(model, c=folder / "c", sensors=sensors).files[1].read_text()


def test_everything_at_once(runs: list[Path], tmp_path: Path) -> None:
    out = {"--series": "s.csv", "--lut": "l.csv", "--c": "c", "--fmu": "d.fmu"}
    words = [w for option, name in out.items() for w in (option, tmp_path / name)]
    result = call(runs[0], "--model", GUO, *words, "--fmi", 2)
    assert result.exit_code == 0, result.output
    names = [
        line.rpartition("/")[2]
        for line in result.output.splitlines()
        if line.startswith("written: ")
    ]
    assert names == ["s.csv", "l.csv", "inove_guo.h", "inove_guo.c", "d.fmu"]
    assert result.output.startswith("run1: 800 rows, error ")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "export: expected something to write: --series, --lut, --c or --fmu, found nothing"),
        (("--series", "s.csv"), "DATA: expected measurements for a series, found none"),
        (("RUN", "--lut", "l.csv"), "DATA: expected --series with it, found none"),
        (("RUN", "--series", "s.xls"), "s.xls: suffix: expected one of .csv, .parquet, .mat, .mf4, found '.xls'"),
        (("--lut", "l.mat"), "l.mat: suffix: expected .csv, found '.mat'"),
        (("--lut", "l.csv", "--report", "r"), "--report: expected --series with it, found none"),
        (("--fmu", "d.zip"), "d.zip: suffix: expected .fmu, found '.zip'"),
        (("--fmu", "d.fmu", "--fmi", "1"), "--fmi: expected 2 or 3, found 1"),
        (("--c", "file"), "file: expected a folder, found a file"),
        (("--c", "file/c"), "file/c/inove_guo.h: expected a folder that can be written to, found "),
        (("RUN", "--series", "RUN"), ": --series: expected another place than DATA, found the same place"),
        (("--lut", "l.csv", "--level", "vehicle"), "--level: expected damper (lab export works on the damper force)"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_one_line_and_nothing_is_written(
    words: tuple[str, ...],
    said: str,
    runs: list[Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("kept")
    before = runs[0].read_bytes()
    result = call(*(str(runs[0]) if w == "RUN" else w for w in words), "--model", GUO)
    assert (result.exit_code, result.output.count("\n")) == (2, 1)
    assert said in result.output
    assert [p.name for p in tmp_path.iterdir()] == ["file"]
    assert runs[0].read_bytes() == before


def test_a_series_of_several_records_overwrites_none_of_them(runs: list[Path]) -> None:
    taken = write_run(runs[0].with_name("s_run1.csv"), 3)
    before = taken.read_bytes()
    with pytest.raises(lab.InputError, match="expected another place than the data"):
        lab.export(truth(), lab.load(*runs, taken), series=taken.with_name("s.csv"))
    assert taken.read_bytes() == before


def test_a_place_that_cannot_be_written_is_one_line(runs: list[Path], tmp_path: Path) -> None:
    (tmp_path / "file").write_text("kept")
    with pytest.raises(
        lab.InputError, match=r"s\.csv: expected a place that can be written, found "
    ):
        lab.export(truth(), lab.load(runs[0]), series=tmp_path / "file" / "s.csv")

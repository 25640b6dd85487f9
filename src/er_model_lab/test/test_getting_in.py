"""From a folder in foreign shape to a fitted model: map, new, add, as commands, and no file is edited by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from er_model_lab.cli.app import app
from lab_help import imposed
from typer.testing import CliRunner

import er_model_lab as lab

DT, N = 0.005, 1600
SHAPES = {
    "small, German": (20.0, 0.005, "Messzeit;Kolbenweg;Kraft", "ms;mm;N", (1e3, 1e3, -1.0)),
    "large, English": (50e3, 0.2, "Time;Stroke;Load", "s;in;kip", (1.0, 1 / 0.0254, 1 / 4448.2216152605)),
}  # fmt: skip
"""Force [N], stroke [m], names, units, and factors to them."""


def run(*words: str) -> str:
    """What a command prints that must end well."""
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    return done.stdout


@pytest.mark.parametrize("shape", SHAPES)
def test_a_foreign_folder_becomes_a_model_with_its_friction(shape: str, tmp_path: Path) -> None:
    force, stroke, names, units, factors = SHAPES[shape]
    rng = np.random.default_rng(len(shape))
    x, v, _, _ = imposed(rng, N)
    x, v = stroke / np.max(np.abs(x)) * x, stroke / np.max(np.abs(x)) * v
    top = float(np.max(np.abs(v)))
    friction = 0.15 * force
    F = force * 0.6 * v / top + friction * np.tanh(v / (0.02 * top))
    F += 2e-3 * force * rng.standard_normal(N)
    folder = tmp_path / "rig"
    folder.mkdir()
    table = np.column_stack([DT * np.arange(N), x, F]) * factors
    rows = [";".join(f"{value:.9g}".replace(".", ",") for value in row) for row in table.tolist()]
    (folder / "lauf 1.csv").write_text("\n".join([names, units, *rows]) + "\n")
    run("map", str(folder))
    start, better = tmp_path / "start.yaml", tmp_path / "better.yaml"
    run("new", "mine", "--from", str(folder), "--out", str(start), "--kind", "passive")
    shown = run(
        "add", "coulomb_friction", str(folder), "--model", str(start), "--out", str(better)
    )
    assert "new model" in shown
    model = lab.load_model(better)
    assert model.value("coulomb_friction", "F_c") == pytest.approx(friction, rel=0.1)
    assert model.rig["stroke"] == pytest.approx(stroke, rel=1e-3)
    assert "rig_before" not in model.history[-1]

"""Duty, voltage, field and yield force: Table 1.1 and (1.1) to (1.6)."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from er_models.catalogue import CATALOGUE
from er_models.files import load_model
from er_models.prediction import predict
from models_help import one_sample

from er_models import field

DUCT = field.Duct(area_piston=6e-4, area_rod=1e-4, length=0.05, radius=0.015, gap=0.7e-3, c=2.0)


def test_table_1_1() -> None:
    kilovolts = [field.voltage(duty) / 1e3 for duty in (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)]
    assert kilovolts == pytest.approx([0.0, 1.0, 2.0, 3.0, 4.0, 5.0])
    assert field.voltage(0.3) == pytest.approx(1500.0)  # the limit of the testbench, section 1.3


def test_field_of_a_gap() -> None:
    assert field.electric_field(0.2, 1e-3) == pytest.approx(1e6)
    assert field.electric_field(0.2, 0.5e-3, 2500.0) == pytest.approx(1e6)


def test_forces_worked_by_hand() -> None:
    """1 kPa in a duct 50 mm long and 0.7 mm wide: 5e-4 m2 2 50 / 0.7 1 kPa."""
    assert field.yield_stress(4e6, 0.5e-3, 0.5) == pytest.approx(1.0)
    assert field.yield_stress(0.0, 1.0, 0.0) == 0.0
    assert field.yield_force(DUCT, 1e3) == pytest.approx(500.0 / 7.0)
    assert field.force_of_pressures(DUCT, 2e4, 1e4) == pytest.approx(2.0 + 5.0)


@pytest.mark.parametrize("beta", [0.2373, 1.0, 1.7])
def test_the_bingham_model_is_this_force(beta: float) -> None:
    """Simplifying (1.2) to (1.6) loses nothing: sigma u^beta is the force of the field at every duty."""
    alpha = 800.0 / 1e6**beta
    target = CATALOGUE["bingham_yield"].hooks["target"]
    sigma = field.sigma(DUCT, alpha, beta)
    for duty in (0.0, 0.05, 0.3, 1.0):
        stress = field.yield_stress(field.electric_field(duty, DUCT.gap), alpha, beta)
        found = target(sigma=sigma, beta=beta, v_0=1e-6, v=0.1, u=duty)
        assert found == pytest.approx(field.yield_force(DUCT, stress), rel=1e-9)


def test_viscous_damping_is_that_of_flow_between_plates() -> None:
    """Numerically: a parabolic profile that carries (A_p - A_s) v through the unrolled duct of width 2 pi R."""
    viscosity, v = 0.05, 0.1
    y = np.linspace(-0.5 * DUCT.gap, 0.5 * DUCT.gap, 20001)
    profile = 1.0 - (2.0 * y / DUCT.gap) ** 2
    width = 2.0 * np.pi * DUCT.radius
    peak = DUCT.area * v / (width * float(np.sum(profile[1:]) * (y[1] - y[0])))
    shear = viscosity * peak * 4.0 / DUCT.gap  # at the wall: mu du/dy
    drop = 2.0 * shear * DUCT.length / DUCT.gap
    force = field.force_of_pressures(DUCT, 0.0, drop)
    assert field.viscous_damping(DUCT, viscosity) * v == pytest.approx(force, rel=1e-6)


def test_the_documented_drawing_becomes_a_model(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The example of docs/results/thesis.md; the model's force is that of the duct."""
    page = Path(__file__).resolve().parents[3] / "docs" / "results" / "thesis.md"
    chapter = page.read_text(encoding="utf-8").split("### From a drawing to a model")[1]
    code = re.search(r"```python\n(.*?)```", chapter, re.S)
    assert code is not None
    monkeypatch.chdir(tmp_path)
    exec(compile(code[1], str(page), "exec"), {})
    x, v, duty = 0.002, 0.05, 0.3
    stress = field.yield_stress(field.electric_field(duty, DUCT.gap), 800.0 / 1e6**1.2, 1.2)
    wanted = field.viscous_damping(DUCT, 0.05) * v + field.yield_force(DUCT, stress) + 300.0 * x
    found = predict(load_model("drawn.yaml"), one_sample(x, v, duty))
    assert found == pytest.approx([wanted], rel=1e-9)

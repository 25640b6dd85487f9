"""What packages offer by their own names: listed for people and for tools, documented, and light to import."""

from __future__ import annotations

import ast
import inspect
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from er_models.files import load_model
from er_models.version import __version__

from test.conftest import ROOT

PACKAGES = ("er_observers", "er_ftc_controller")
HEAVY = {"cvxpy", "matplotlib", "numba", "numpy", "plotly", "rclpy", "rich", "scipy", "typer"}
"""What importing a package does not wait for."""
NEVER = {
    "cvxpy",
    "er_damper_msgs",
    "er_ros_common",
    "matplotlib",
    "plotly",
    "rclpy",
    "rich",
    "typer",
}
"""What nothing but a synthesis needs."""
CAR = ROOT / "config/vehicles/inove_quarter_car.yaml"
EACH = pytest.mark.parametrize("package", PACKAGES)


def names(package: str) -> list[str]:
    """Names of a package, in order."""
    found: list[str] = import_module(package).__all__
    return found


def loaded(code: str) -> set[str]:
    """Packages that are loaded after this code, in a process of its own."""
    script = f"import sys\n{code}\nprint(*{{name.split('.')[0] for name in sys.modules}})"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    return set(done.stdout.split())


@EACH
def test_tools_see_the_names_that_there_are(package: str) -> None:
    path = ROOT / "src" / package / package / "__init__.py"
    tree = ast.parse(path.read_text(encoding="utf-8"))
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    seen = [n for node in block.body if isinstance(node, ast.ImportFrom) for n in node.names]
    assert all(each.name == each.asname for each in seen)
    assert sorted(each.name for each in seen) == names(package)
    homes = {
        n.name: node.module
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for n in node.names
    }
    for name, home in homes.items():
        assert getattr(import_module(package), name) is getattr(import_module(str(home)), name)


@EACH
def test_every_name_is_documented(package: str) -> None:
    for name in names(package):
        thing = getattr(import_module(package), name)
        if inspect.isclass(thing) or inspect.isfunction(thing):
            text = inspect.getdoc(thing) or ""
            assert len(text) > 20, name
            assert not text.startswith(f"{name}("), f"{name}: that of a dataclass, by itself"
    assert import_module(package).__version__ == __version__


@EACH
def test_a_star_brings_the_names_and_no_other_is_there(package: str) -> None:
    space: dict[str, Any] = {}
    exec(f"from {package} import *", space)
    assert set(names(package)) <= set(space)
    assert dir(import_module(package)) == names(package)
    with pytest.raises(AttributeError, match=f"module '{package}' has no attribute 'stepp'"):
        _ = import_module(package).stepp


@EACH
def test_importing_it_waits_for_nothing(package: str) -> None:
    assert loaded(f"import {package}") & HEAVY == set()
    every = [
        name
        for name in names(package)
        if name not in ("synthesise", "Wish", "Certificate", "Design")
    ]
    assert loaded(f"from {package} import {', '.join(every)}") & NEVER == set()
    assert "cvxpy" in loaded(f"from {package} import synthesise")


def test_an_observer_runs_by_the_names_of_its_package() -> None:
    import er_observers as observers

    gains = observers.ready("unified", load_model(CAR))
    assert gains.observer == "unified"
    state = observers.start(gains, observers.Sample(0.0, 0.1, -0.2, 0.1))
    for k in range(1, 400):
        swing = 0.5 * np.sin(0.1 * k)
        state, estimate = observers.step(
            gains, state, observers.Sample(0.005 * k, swing, -swing, 0.1)
        )
    assert estimate.status in (observers.Status.OK, observers.Status.WEAK)
    assert abs(estimate.force) > 0.0
    assert observers.payload_of(gains, state).text
    assert observers.lose(gains, state, 2.1).estimate.status is observers.Status.INVALID


def test_a_synthesis_by_the_name_of_its_package_is_saved_and_loaded(tmp_path: Path) -> None:
    import er_observers as observers

    car, path = load_model(CAR), tmp_path / "gains.yaml"
    claim, certificate = observers.synthesise("nlpv_polytopic", car)
    assert certificate.peak.gain < claim.solution.gamma
    observers.save_gains(path, "nlpv_polytopic", car, claim, certificate)
    assert observers.observer_of(path) == "nlpv_polytopic"
    assert observers.load_gains(path, car).figures == certificate.figures


def test_the_controller_runs_by_the_names_of_its_package() -> None:
    import er_ftc_controller as ftc

    car = load_model(CAR)
    gains = ftc.load_gains("lpv_ftc", car)
    belief = {"largest_deflection": 0.05, "largest_velocity": 5.0}
    given = ftc.FtcParameters(u_min=0.0, u_max=0.3, safe_duty=0.1, mu=1.6, **belief)  # type: ignore[arg-type]
    controller = ftc.controller_of(given, car, gains)
    state = ftc.start(controller)
    state = ftc.hear(controller, state, ftc.Faults(0.0, 1.0, 0.6, 1.0, certain=True, usable=True))
    for k in range(1, 100):
        sample = ftc.Sample(0.003 * np.sin(0.1 * k), 0.06 * np.cos(0.1 * k))
        state, command = ftc.step(controller, state, 0.005 * k, sample)
    assert command.mode is ftc.Mode.FAULT_TOLERANT
    assert 0.0 <= command.duty <= 0.3


def test_a_controller_that_cannot_be_says_so_by_the_name_of_its_package() -> None:
    import er_ftc_controller as ftc

    with pytest.raises(ftc.NoController, match="LPV controller"):
        ftc.synthesise(load_model(CAR), wish=ftc.Wish(radius=20.0))

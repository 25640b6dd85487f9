"""What `lab open` imports before its address is printed."""

from __future__ import annotations

import subprocess
import sys

import pytest

pytest.importorskip("nicegui", reason="the package nicegui is not installed")
START = "import er_model_lab.cli.app, er_model_lab.session.live_desk, er_model_lab.page.server"
DEAR = {
    "scipy.signal", "scipy.stats", "scipy.optimize", "scipy.linalg", "scipy.spatial", "scipy.integrate", "scipy.io",
    "pandas", "pyarrow", "matplotlib", "cvxpy", "dask", "sympy", "rclpy", "tornado", "aiohttp",
}  # fmt: skip
"""What only work on data needs, or nothing of the page."""


def test_the_page_is_offered_before_what_only_work_on_data_needs_is_imported() -> None:
    said = subprocess.run(
        [sys.executable, "-c", f"{START}\nimport sys\nprint(*sys.modules)"],
        capture_output=True, text=True, check=True, timeout=60,
    ).stdout.split()  # fmt: skip
    assert "nicegui" in said
    assert DEAR & set(said) == set()

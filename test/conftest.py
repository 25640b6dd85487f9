"""Fixtures of the tests that look at the repository as a whole."""

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture
def root() -> Path:
    return ROOT


@pytest.fixture(scope="session")
def pace(request: pytest.FixtureRequest) -> float:
    """Seconds of a simulated world in a second: fewer where a machine was too busy for real time (`--pace`)."""
    return float(request.config.getoption("--pace", 1.0))

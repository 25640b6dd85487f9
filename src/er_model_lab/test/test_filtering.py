"""Spectra and filters against those of SciPy, which takes longer to import than they take to use."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from er_model_lab.filtering import cross, fading, kaiser, low_pass, welch
from er_models.model import Array
from scipy import signal

import er_model_lab

RATE = 200.0


def walks(n: int) -> tuple[Array, Array]:
    """Two channels (n,) that have something in common."""
    rng = np.random.default_rng(n)
    y = rng.standard_normal(n).cumsum()
    return y, np.roll(y, 3) + rng.standard_normal(n)


@pytest.mark.parametrize(("n", "length"), [(3000, 512), (1001, 333), (256, 256), (301, 300)])
def test_spectra_are_those_of_scipy(n: int, length: int) -> None:
    y, z = walks(n)
    for linear, detrend in ((False, "constant"), (True, "linear")):
        f, found = welch(y, RATE, length, linear=linear)
        at, power = signal.welch(y, RATE, nperseg=length, detrend=detrend)
        assert np.allclose(f, at)
        assert np.allclose(found, power, rtol=1e-9, atol=1e-12 * power.max())
    _, found_both = cross(y, z, RATE, length)
    _, both = signal.csd(y, z, RATE, nperseg=length)
    assert np.allclose(found_both, both, rtol=1e-9, atol=1e-12 * np.abs(both).max())


@pytest.mark.parametrize("down", [45.0, 30.0])
def test_a_low_pass_is_that_of_scipy(down: float) -> None:
    taps, beta = kaiser(down, 0.1)
    assert (taps, beta) == signal.kaiserord(down, 0.1)
    for n in (taps, 19, 20):
        assert np.allclose(low_pass(n, 0.4, beta), signal.firwin(n, 0.4, window=("kaiser", beta)))


def test_what_fades_is_what_a_recursion_gives() -> None:
    y = np.stack(walks(400))
    for keeps in (0.0, 0.93, 1.0):
        wanted = signal.lfilter([1.0], [1.0, -keeps], y)
        assert np.allclose(fading(y, keeps), wanted, rtol=1e-12, atol=1e-12)
        assert np.allclose(fading(y[1], keeps), wanted[1], rtol=1e-12, atol=1e-12)
    assert fading(y[0, :1], 0.5).tolist() == [y[0, 0]]


def test_no_question_to_the_lab_waits_for_scipy_signal() -> None:
    sources = Path(er_model_lab.__file__).parent.rglob("*.py")
    using = {
        f.name for f in sources if "from scipy.signal import" in f.read_text(encoding="utf-8")
    }
    assert using == {"simulated.py"}  # what `er study alarms` draws

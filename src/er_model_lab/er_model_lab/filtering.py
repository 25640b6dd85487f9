"""Spectra and filters of channels, as SciPy's to rounding: importing `scipy.signal` takes longer than most questions.

Welch: pieces that overlap by half under Hann's window, each without its mean (or its line); one-sided densities.
"""

from __future__ import annotations

import numpy as np
from er_models.model import Array
from numpy.typing import NDArray


def welch(y: Array, rate: float, length: int, *, linear: bool = False) -> tuple[Array, Array]:
    """Frequencies [Hz] and density of the power per Hz of a channel (n,), of pieces of `length` samples, n at most.

    linear: each piece without its line.
    """
    f, power = cross(y, y, rate, length, linear=linear)
    return f, power.real


def cross(
    y: Array, z: Array, rate: float, length: int, *, linear: bool = False
) -> tuple[Array, NDArray[np.complex128]]:
    """Frequencies [Hz] and the cross density conj(Y) Z per Hz of two channels (n,)."""
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(length) / length)
    of_y = _lines(y, window, linear=linear)
    of_z = of_y if z is y else _lines(z, window, linear=linear)
    density = np.asarray((of_y.conj() * of_z).mean(axis=0) / (rate * float(window @ window)))
    density[1 : (length + 1) // 2] *= 2.0
    return np.asarray(np.fft.rfftfreq(length, 1.0 / rate)), density


def _lines(y: Array, window: Array, *, linear: bool) -> NDArray[np.complex128]:
    """Lines (pieces, length // 2 + 1) of the pieces of a channel."""
    n = window.size
    pieces = np.lib.stride_tricks.sliding_window_view(y, n)[:: n - n // 2]
    pieces = pieces - pieces.mean(axis=1, keepdims=True)
    if linear:
        t = np.arange(n) - 0.5 * (n - 1)
        pieces -= np.outer(pieces @ t / float(t @ t), t)
    return np.fft.rfft(pieces * window)


def low_pass(taps: int, cutoff: float, beta: float) -> Array:
    """Taps of a low pass by Kaiser's window; cutoff: share of half the rate; beta: of the window."""
    k = np.arange(taps) - 0.5 * (taps - 1)
    kernel = np.sinc(cutoff * k) * np.kaiser(taps, beta)
    return np.asarray(kernel / kernel.sum())


def kaiser(down: float, width: float) -> tuple[int, float]:
    """Taps and beta of a low pass that stops all by 21 to 50 dB; width: of its slope as a share of half the rate."""
    beta = 0.5842 * (down - 21.0) ** 0.4 + 0.07886 * (down - 21.0)
    return int(np.ceil((down - 7.95) / 2.285 / (np.pi * width) + 1.0)), beta


def fading(y: Array, keeps: float) -> Array:
    """Sums (..., n) of a channel and of `keeps` times the sum one sample before."""
    from scipy.linalg.lapack import dtbtrs

    bands = np.ones((2, y.shape[-1]))
    bands[1] = -keeps
    sums, _ = dtbtrs(bands, y.T, uplo="L")
    return np.asarray(sums.T).reshape(y.shape)

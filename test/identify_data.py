"""Measurements of the dampers of Tables 1.2 to 1.4 and 1.6, from the printed laws and an integrator of their own.

Nothing of the laws is shared with the library: the sign is a sign, the parameters switch at zero velocity, the
lag is integrated exactly over steps of 0.1 ms. The piston follows sines; every sensor of the rig has noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from er_records.record import Record
from scipy.signal import lfilter

DT = 0.005
FINE = 50
DUTIES = (0.0, 0.1, 0.15, 0.2, 0.25, 0.3)
WAVES = ((1.0, 0.009), (2.0, 0.009), (4.0, 0.0055))
"""Frequency [Hz] and amplitude [m]: up to 0.14 m/s, within the testbench."""
TAU = (0.0137, 0.0221, 0.0365, 0.055, 0.0631)
"""Table 1.4, duty 0.1 to 0.3."""
NOISE = {
    "deflection": 2e-5, "deflection_velocity": 1e-3, "damper_force": 0.15,
    "sprung_acceleration": 0.025, "unsprung_acceleration": 0.025,
}  # fmt: skip


@dataclass(frozen=True)
class Truth:
    """A damper as the thesis prints it: parameters by name, those of compression first where there are two."""

    model: str
    law: str
    passive: tuple[tuple[float, float], ...]
    shape: tuple[tuple[float, ...], ...]
    tau: tuple[float, ...]
    strength: float = 1.0

    def force(self, x: np.ndarray, v: np.ndarray, u: float) -> np.ndarray:
        """Damper force (n,) [N] along a motion sampled every DT / FINE, at a constant duty."""
        side = (v > 0).astype(int) * (len(self.passive) - 1)
        k0, c0 = np.array(self.passive).T[:, side]
        asked = self._asked(x, v, u, side)
        if self.tau and u > 0.0:
            keep = np.exp(-DT / FINE / self.response_time(u))
            middle = np.append(0.5 * (asked[1:] + asked[:-1]), asked[-1])
            asked, _ = lfilter([0.0, 1.0 - keep], [1.0, -keep], middle, zi=[asked[0]])
        return self.strength * (k0 * x + c0 * v + asked)

    def _asked(self, x: np.ndarray, v: np.ndarray, u: float, side: np.ndarray) -> np.ndarray:
        """Yield force the field asks for."""
        p = np.array(self.shape).T[:, side]
        if self.law == "bingham":
            return p[0] * u ** p[1] * np.sign(v) if u > 0.0 else np.zeros(v.size)
        return p[0] * u * np.tanh(p[1] * x + p[2] * v)

    def response_time(self, u: float) -> float:
        """Response time [s]: constant, the quadratic (1.21) of three numbers, or Table 1.4 of five."""
        if len(self.tau) == 3:
            return self.tau[0] + self.tau[1] * u + self.tau[2] * u**2
        return float(np.interp(u, np.linspace(0.1, 0.3, len(self.tau)), self.tau))

    def values(self) -> dict[str, float]:
        """True value of every parameter, by the name it has in the model file."""
        names = {"bingham": ("sigma", "beta"), "guo": ("f_c", "k1", "c1")}[self.law]
        strong = {"k0", "c0", "sigma", "f_c"}
        ends = ("_c", "_r") if len(self.passive) == 2 else ("",)
        out: dict[str, float] = {}
        for end, passive, shape in zip(ends, self.passive, self.shape, strict=True):
            both = zip(("k0", "c0", *names), (*passive, *shape), strict=True)
            out |= {n + end: v * (self.strength if n in strong else 1.0) for n, v in both}
        places = {
            0: (),
            1: ("tau",),
            3: ("tau_0", "tau_1", "tau_2"),
            5: [f"tau_{k}" for k in range(1, 6)],
        }
        return out | dict(zip(places[len(self.tau)], self.tau, strict=True))


PASSIVE = ((263.1168, 64.6433), (170.4045, 68.8289))
GUO = ((29.2780, 204.0283, 492.6448), (28.0699, 218.1615, 512.6200))
BINGHAM = ((12.8157, 0.2373), (17.0442, 0.3948))
TRUTHS = {
    "guo": Truth("inove_guo", "guo", PASSIVE[:1], GUO[:1], (0.0365,)),
    "bingham": Truth("inove_bingham_dynamic", "bingham", PASSIVE[:1], BINGHAM[:1], (0.0365,)),
    "guo_quadratic": Truth(
        "inove_guo_tau_quadratic", "guo", PASSIVE[:1], GUO[:1], (0.002, 0.1124, 0.3643)
    ),
    "guo_complete": Truth("inove_guo_complete", "guo", PASSIVE, GUO, TAU),
    "bingham_complete": Truth("inove_bingham_complete", "bingham", PASSIVE, BINGHAM, TAU),
}
"""Table 1.6; Bingham's first column of Table 1.2; (1.21); Tables 1.3 and 1.4; Tables 1.2 and 1.4."""


def record(
    truth: Truth, wave: tuple[float, float], duty: float, seconds: float, rng: np.random.Generator
) -> Record:
    """One sine of (frequency, amplitude) at one duty."""
    frequency, amplitude = wave
    n, w, phase = round(seconds / DT), 2 * np.pi * frequency, rng.uniform(0, 2 * np.pi)
    t = np.arange(n * FINE) * DT / FINE
    x, v = amplitude * np.sin(w * t + phase), amplitude * w * np.cos(w * t + phase)
    force = truth.force(x, v, duty)[::FINE]
    x, v = x[::FINE], v[::FINE]
    true = {
        "deflection": x, "deflection_velocity": v, "damper_force": force,
        "sprung_acceleration": -(w**2) * x, "unsprung_acceleration": np.zeros(n),
    }  # fmt: skip
    sd = NOISE | {"damper_force": NOISE["damper_force"] * truth.strength}
    channels = {k: y + sd[k] * rng.standard_normal(n) for k, y in true.items()}
    channels["duty"] = np.full(n, duty)
    return Record(f"{frequency:g}Hz_{duty:g}", np.arange(n) * DT, channels)


def program(
    truth: Truth, seed: int, seconds: float = 6.0, duties: Sequence[float] = DUTIES
) -> list[Record]:
    """The test program of section 1.5: every sine at every duty."""
    rng = np.random.default_rng(seed)
    return [record(truth, wave, u, seconds, rng) for u in duties for wave in WAVES]

"""What can be hidden: for each truth the devices that show it, and its rows of laws drawn for a rig."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from test.rough import device as d
from test.rough.device import COLUMNS, LAWS, Array
from test.rough.rig import DRIVEN, Rig, log_uniform

Random = np.random.Generator
Rows = dict[int, tuple[float, ...]]
ALL = ("passive", "er", "mr", "brake", "pneumatic")
OIL = ("passive", "er", "mr")


@dataclass(frozen=True)
class Truth:
    """One hidden effect.

    Attributes:
        name: key of `names.RIGHT`.
        devices: those that may have it.
        draw: its rows; the first column of the first is its strength.
        most: largest strength that is plausible, by itself; infinity where only the force limits it.
    """

    name: str
    devices: tuple[str, ...]
    draw: Callable[[Random, Scale], Rows]
    most: float = float("inf")


def sign(rng: Random) -> float:
    """1 or -1."""
    return float(rng.choice([-1.0, 1.0]))


class Scale(NamedTuple):
    """Peak force [N], stroke [m], velocity [m/s] and duty of a rig, and the values of its base."""

    F: float
    X: float
    V: float
    U: float
    base: Array


def narrow(g: Random, s: Scale) -> float:
    """Width of a reversal [m/s]."""
    return s.V * log_uniform(g, 0.01, 0.04)


def _dahl(g: Random, s: Scale) -> tuple[float, ...]:
    """Rests anywhere within its band."""
    return (0.12 * s.F, s.X * log_uniform(g, 0.02, 0.12), 0.0, g.uniform(-0.7, 0.7))


def _dahl_field(g: Random, s: Scale) -> tuple[float, ...]:
    """Its level grows with the field."""
    bend = s.X * log_uniform(g, 0.02, 0.12)
    return (0.05 * s.F, bend, g.uniform(1.0, 4.0) / s.U, g.uniform(-0.7, 0.7))


def _stribeck(g: Random, s: Scale) -> tuple[float, ...]:
    """A breakaway above sliding friction, of which a brake's base has its own."""
    hump, width = s.V * g.uniform(0.04, 0.12), narrow(g, s)
    return (0.1 * s.F, hump, width, 0.0 if s.base[d.FC] > 0.0 else g.uniform(0.4, 1.0))


def _valves(g: Random, s: Scale) -> tuple[float, ...]:
    """Opens at another force in each direction."""
    share, opens = g.uniform(1.0, 4.0), g.uniform(0.25, 0.5, 2) * s.base[d.C0] * s.V
    return (share, *opens, 0.03 * float(s.base[d.C0]) * s.V, g.uniform(0.4, 1.6))


def _void(g: Random, s: Scale) -> tuple[float, ...]:
    """A share that the fluid's largest force is cut by."""
    full = float(s.base[d.C0]) * s.V + float(s.base[d.FY]) * s.U
    return (g.uniform(0.3, 0.6), full, 0.004 * s.X)


def _brake_play(g: Random, s: Scale) -> Rows:
    """Friction that bends before it slides, behind a gap."""
    force, bend, _, rests = _dahl(g, s)
    gap = (s.X * g.uniform(0.03, 0.1), 40.0 * s.F / s.X)
    return {d.PLAY: gap, d.DAHL: (2.0 * force, 0.5 * bend, 0.0, rests)}


def _threshold(g: Random, s: Scale) -> tuple[float, ...]:
    """A duty below which next to nothing happens, with a soft edge."""
    share = g.uniform(0.06, 0.15)
    return (share * s.U, 0.1 * share * s.U)


def _heat(g: Random, s: Scale) -> tuple[float, ...]:
    """What a fifth of the largest power would take off in the long run."""
    return (g.uniform(0.4, 1.2), g.uniform(4.0, 12.0), 0.2 * s.F * s.V)


def _of(
    law: int, values: Callable[[Random, Scale], tuple[float, ...]]
) -> Callable[[Random, Scale], Rows]:
    """A truth of one law."""
    return lambda g, s: {law: values(g, s)}


def _late(g: Random, s: Scale) -> tuple[float, ...]:
    """A time [s] of the chain from duty to field."""
    return (log_uniform(g, 0.005, 0.02),)


def _fading(g: Random, s: Scale) -> tuple[float, ...]:
    """A share that is lost, and the time of half the loss [s]."""
    return (g.uniform(0.2, 0.4), g.uniform(3.0, 10.0))


def _sensor(g: Random, s: Scale) -> tuple[float, ...]:
    """A delay or lag of the force channel [s]."""
    return (g.uniform(0.004, 0.012),)


_CHECK = _of(d.CHECK, lambda g, s: (sign(g) * 0.15 * s.F / s.V, s.V * g.uniform(0.01, 0.05)))
_DIRECTION = _of(
    d.DIRECTION, lambda g, s: (0.1 * s.F, sign(g) * g.uniform(0.3, 0.6), narrow(g, s))
)
_MAXWELL = _of(
    d.MAXWELL, lambda g, s: (0.3 * s.F / s.X, log_uniform(g, 0.04, 0.3), g.uniform(0.0, 0.2))
)
_THIN = _of(
    d.THIN, lambda g, s: (g.uniform(0.3, 0.6), s.V * g.uniform(0.15, 0.5), g.uniform(1.0, 2.0))
)
_TABLE: tuple[tuple[str, tuple[str, ...], Callable[[Random, Scale], Rows], float], ...] = (
    ("coulomb", ("passive", "er", "mr", "pneumatic"), _of(d.COULOMB, lambda g, s: (0.08 * s.F, narrow(g, s))), np.inf),
    ("stribeck", ("passive", "brake"), _of(d.STRIBECK, _stribeck), np.inf),
    ("dahl", ALL, _of(d.DAHL, _dahl), np.inf),
    ("dahl_field", ("mr", "er"), _of(d.DAHL, _dahl_field), np.inf),
    ("direction", ("passive", "brake"), _DIRECTION, np.inf),
    ("loaded", ("brake", "passive"), _of(d.LOADED, lambda g, s: (g.uniform(0.2, 0.5), narrow(g, s))), 1.5),
    ("orifice", OIL, _of(d.ORIFICE, lambda g, s: (0.2 * s.F / s.V**2, s.V * g.uniform(0.02, 0.1))), np.inf),
    ("check", (*OIL, "pneumatic"), _CHECK, np.inf),
    ("knee", ("passive", "mr"), _of(d.KNEE, _valves), 6.0),
    ("thin", OIL, _THIN, 0.85),
    ("taper", ("passive", "er", "brake"), _of(d.TAPER, lambda g, s: (0.5 * s.F / s.V, s.X)), np.inf),
    ("stop", ALL, _of(d.STOP, lambda g, s: (2.0 * s.F / s.X, s.X * g.uniform(0.5, 0.75), 0.5 * s.X)), np.inf),
    ("gas", ALL, _of(d.GAS, lambda g, s: (0.3 * s.F, s.X * g.uniform(1.5, 3.0), g.uniform(1.1, 1.4))), np.inf),
    ("offset", OIL, _of(d.OFFSET, lambda g, s: (sign(g) * 0.05 * s.F,)), np.inf),
    ("maxwell", OIL, _MAXWELL, np.inf),
    ("mount", (*OIL, "brake"), _of(d.MOUNT, lambda g, s: (0.1 * s.X / s.F, 0.4 * s.X)), np.inf),
    ("play", OIL, _of(d.PLAY, lambda g, s: (s.X * g.uniform(0.03, 0.1), 400.0 * s.F / s.X)), np.inf),
    ("brake_play", ("brake",), _brake_play, np.inf),
    ("inertia", ALL, _of(d.INERTIA, lambda g, s: (0.1 * s.F * s.X / s.V**2,)), np.inf),
    ("void", OIL, _of(d.VOID, _void), 0.85),
    ("thicken", ("er", "mr"), _of(d.THICKEN, lambda g, s: (0.3 * s.F / s.V / s.U, s.U)), np.inf),
    ("stiffen", DRIVEN, _of(d.STIFFEN, lambda g, s: (0.3 * s.F / s.X / s.U, s.X)), np.inf),
    ("mixed", ("er", "pneumatic"), _of(d.MIXED, lambda g, s: (float(g.choice([0.5, -0.35])), s.U)), 0.8),
    ("saturate", ("er", "pneumatic"), _of(d.SATURATE, lambda g, s: (g.uniform(0.6, 2.0), s.U)), 4.0),
    ("late", DRIVEN, _of(d.LATE, _late), 0.05),
    ("amplifier", DRIVEN, _of(d.AMPLIFIER, _late), 0.06),
    ("threshold", ("er", "mr"), _of(d.THRESHOLD, _threshold), np.inf),
    ("switching", DRIVEN, _of(d.SWITCHING, lambda g, s: (sign(g) * g.uniform(0.4, 1.1),)), 1.6),
    ("slowing", ("er", "mr"), _of(d.SLOWING, lambda g, s: (g.uniform(0.5, 1.3), s.U)), 2.0),
    ("remanent", ("mr",), _of(d.REMANENT, lambda g, s: (g.uniform(0.3, 0.7), 0.3 * s.U)), 0.95),
    ("pressed", ("pneumatic", "mr"), _of(d.PRESSED, lambda g, s: (0.2 * s.F / s.U,)), np.inf),
    ("heat", OIL, _of(d.HEAT, _heat), 4.0),
    ("fade", ("er", "mr"), _of(d.FADE, _fading), 0.8),
    ("wear", ("passive", "brake"), _of(d.WEAR, _fading), 0.8),
    ("cogging", ("brake", "passive"), _of(d.COGGING, lambda g, s: (0.1 * s.F, s.X * g.uniform(0.15, 0.4))), np.inf),
    ("zero", ("er", "pneumatic"), _of(d.ZERO, lambda g, s: (sign(g) * 0.1 * s.X,)), np.inf),
    ("force_late", ("passive", "er", "brake"), _of(d.FORCE_LATE, _sensor), 0.03),
    ("force_slow", ("passive", "mr"), _of(d.FORCE_SLOW, _sensor), 0.03),
)  # fmt: skip
TRUTHS = {row[0]: Truth(*row) for row in _TABLE}


def scale_of(rig: Rig) -> Scale:
    """The scales that a truth is drawn in."""
    return Scale(rig.force, rig.stroke, rig.velocity, rig.duty, rig.base)


def table(rows: Rows) -> Array:
    """The table of laws (36, 5) with these rows, all others off."""
    out = np.zeros((len(LAWS), COLUMNS))
    for index, values in rows.items():
        out[index, : len(values)] = values
    return out


def stronger(truth: Truth, rows: Rows, factor: float) -> Rows:
    """The rows with the strength times a factor, up to the largest that is plausible."""
    first = next(iter(rows))
    value = factor * rows[first][0]
    value = float(np.clip(value, -truth.most, truth.most))
    return {**rows, first: (value, *rows[first][1:])}

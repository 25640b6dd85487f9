"""Folders as other rigs write them: a damper of any size with a hidden effect, under names, units and signs of theirs.

The damper has equations of its own, in NumPy, and none of the kernel's.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
DT, SECONDS, RECORDS, FINE = 0.005, 9.0, 2, 25
DELAY, POWER = 0.004, 1.7
"""Delay of a force channel [s], and power of a field."""
NOISE = 3e-3
"""Standard deviation of the measured force over its peak."""
DECIMALS = 7
"""Significant digits of a table."""
TIMES = ("Zeit", "Time", "Messzeit", "timestamp", "t")
STROKES = ("Kolbenweg", "Weg", "Hub", "Stroke", "Displacement", "Position_VL", "Federweg")
SPEEDS = ("Geschwindigkeit", "Velocity", "Kolbengeschwindigkeit", "Speed")
FORCES = ("Kraft", "Force", "Load", "Dämpferkraft", "Kraftmessdose", "LoadCell")
DUTIES = {
    "A": ("Strom", "Current", "I_coil"),
    "V": ("Spannung", "Voltage"),
    "%": ("PWM", "Ansteuerung", "Duty"),
}
SECOND = {"s": 1.0, "ms": 1e3}
METRE = {"m": 1.0, "cm": 1e2, "mm": 1e3, "in": 1 / 0.0254}
NEWTON = {
    "N": 1.0, "kN": 1e-3, "daN": 0.1, "kgf": 1 / 9.80665, "lbf": 1 / 4.4482216152605, "kip": 1 / 4448.2216152605,
}  # fmt: skip
MARKS = ("{}", "{} [{}]", "{} ({})", "{} / {}", "{} in {}")
"""How a unit stands behind a name; the first: in a row of its own."""
SHAPES = ("semicolon", "comma", "tab", "tdms", "mat")
_ANY = ("gas_spring", "end_stop", "quadratic_damping", "preload", "force_delay")
HIDDEN = {
    "er": (*_ANY, "coulomb_friction", "asymmetric_damping", "field_exponent"),
    "mr": (*_ANY, "asymmetric_damping", "field_exponent"),
    "passive": (*_ANY, "coulomb_friction"),
    "friction": (*_ANY, "asymmetric_damping"),
}
"""Kinds of start models, and effects that none of them holds."""


@dataclass(frozen=True)
class Foreign:
    """What was made: kind of damper, hidden effect, peak force [N], stroke [m], answers that no column can give."""

    kind: str
    hidden: str
    force: float
    stroke: float
    shape: str
    units: Mapping[str, str]
    said: Mapping[str, str] = field(default_factory=dict)


def motion(rng: np.random.Generator, n: int, stroke: float) -> tuple[Array, Array]:
    """Deflection [m] and velocity [m/s] of six sines that reach a stroke, at `FINE` points a sample (FINE n,)."""
    w = 2 * np.pi * np.array([0.7, 1.3, 2.1, 3.4, 5.2, 7.3]) * rng.uniform(0.85, 1.15, 6)
    angle = np.multiply.outer(np.arange(FINE * n) * (DT / FINE), w) + rng.uniform(
        0, 2 * np.pi, w.size
    )
    x, v = np.sin(angle) @ (1 / w), np.cos(angle) @ np.ones(w.size)
    scale = stroke / np.max(np.abs(x))
    return scale * x, scale * v


def yielding(u: Array, gate: Array, tau: float) -> Array:
    """Yield force (n,) over its largest: duty times gate, (1.12) with a response time [s]; gate (FINE n,) is finer."""
    goal = np.repeat(u, FINE) * gate
    h, step = np.empty(goal.size), DT / FINE
    keep, h[0] = np.exp(-step / tau), goal[0]
    for k in range(1, goal.size):
        h[k] = goal[k - 1] + keep * (h[k - 1] - goal[k - 1])
    return h[::FINE]


def hidden_force(effect: str, size: float, x: Array, v: Array, stroke: float, top: float) -> Array:
    """Force (n,) of an effect; size: its largest [N], top: the largest velocity [m/s]."""
    laws: dict[str, Callable[[], Array]] = {
        "coulomb_friction": lambda: 0.6 * size * np.sqrt(v**2 / (v**2 + (0.015 * top) ** 2)) * np.sign(v),
        "gas_spring": lambda: size * (x / stroke) ** 3,
        "end_stop": lambda: size * np.sign(x) * (np.maximum(np.abs(x) / stroke - 0.7, 0.0) / 0.3) ** 1.5,
        "quadratic_damping": lambda: size * v * np.abs(v) / top**2,
        "asymmetric_damping": lambda: size * np.maximum(v, 0.0) / top,
        "preload": lambda: np.full(x.size, 0.25 * size),
    }  # fmt: skip
    return laws[effect]() if effect in laws else np.zeros(x.size)


def measured(
    rng: np.random.Generator, kind: str, hidden: str, force: float, stroke: float
) -> list[dict[str, Array]]:
    """Records of a damper [SI]: t, x, v, F and, where the kind follows one, u from 0 to 1."""
    n = round(SECONDS / DT)
    driven, records = kind in ("er", "mr"), []
    c, level, friction, k, share = rng.uniform(
        [0.35, 0.2, 0.12, 0.05, 0.25], [0.55, 0.4, 0.2, 0.15, 0.5]
    )
    tau, skew = rng.uniform(0.015, 0.035), rng.uniform(0.4, 0.7)
    motions = [motion(rng, n, stroke * s) for s in (1.0, rng.uniform(0.85, 1.0))]
    top = float(np.max(np.abs(motions[0][1])))
    width = 0.02 * top
    for fine_x, fine_v in motions:
        x, v = fine_x[::FINE], fine_v[::FINE]
        F = force * (c * v / top + k * x / stroke)
        if kind == "passive":
            F = F - force * c * skew * np.minimum(v, 0.0) / top
        if kind in ("mr", "friction"):
            F = F + friction * force * np.tanh(v / width)
        F = F + hidden_force(hidden, share * force, x, v, stroke, top)
        record = {"t": np.arange(n) * DT, "wished": x}
        if driven:
            u = np.repeat(rng.choice([0.0, 0.33, 0.67, 1.0], n // 120 + 1), 120)[:n]
            u[:120] = 1.0
            shown = u**POWER if hidden == "field_exponent" else u
            F = F + level * force * yielding(shown, np.tanh(fine_v / width), tau)
            record["u"] = u
        t, late = record["t"], DELAY if hidden == "force_delay" else 0.0
        record["F"] = np.interp(t - late, t, F) + NOISE * force * rng.standard_normal(n)
        record["x"] = x + 2e-4 * stroke * rng.standard_normal(n)
        record["v"] = v + 2e-3 * top * rng.standard_normal(n)
        records.append(record)
    return records


def make(folder: Path, seed: int, kind: str | None = None) -> Foreign:
    """A folder of two records of a damper that nobody knows; everything is drawn from the seed."""
    rng = np.random.default_rng(seed)
    kind = kind or str(rng.choice(list(HIDDEN)))
    hidden = str(rng.choice(HIDDEN[kind]))
    force, stroke = np.exp(rng.uniform(np.log([20.0, 0.005]), np.log([50e3, 0.2])))
    records = measured(rng, kind, hidden, float(force), float(stroke))
    shape = str(rng.choice(SHAPES))
    around, turned = rng.choice([-1.0, 1.0], 2)
    style = int(rng.integers(len(MARKS)))
    full, unit = rng.uniform(0.5, 5.0), str(rng.choice(list(DUTIES)))
    full = 100.0 if unit == "%" else full
    length = str(rng.choice(list(METRE)))
    speed = f"{length}/s" if length != "cm" else "m/s"
    columns = [
        ("t", str(rng.choice(TIMES)), *_pick(rng, SECOND)),
        ("x", str(rng.choice(STROKES)), length, around * METRE[length]),
        ("F", str(rng.choice(FORCES)), *_pick(rng, NEWTON, turned * around)),
    ]
    if rng.uniform() < 0.5:
        columns.append(("v", str(rng.choice(SPEEDS)), speed, around * METRE[speed.split("/")[0]]))
    if "u" in records[0]:
        columns.append(("u", str(rng.choice(DUTIES[unit])), unit, full))
    others = [
        ("t", "Zyklus", "", 0.0),
        ("wished", f"{columns[1][1]}_soll", length, around * METRE[length]),
    ]
    columns += [each for each in others if rng.uniform() < 0.5]
    columns = [columns[0], *(columns[1 + k] for k in rng.permutation(len(columns) - 1))]
    folder.mkdir(parents=True)
    for number, record in enumerate(records, start=1):
        table = {f"{name}": record[key] * factor for key, name, _, factor in columns}
        units = {name: unit for _, name, unit, _ in columns}
        WRITERS[shape](folder / f"Lauf {number}", table, units, style)
    said = _said(columns) if shape == "mat" else {}
    return Foreign(
        kind, hidden, float(force), float(stroke), shape, {c[1]: c[2] for c in columns}, said
    )


def _pick(
    rng: np.random.Generator, units: Mapping[str, float], sign: float = 1.0
) -> tuple[str, float]:
    """A unit and the factor to it."""
    unit = str(rng.choice(list(units)))
    return unit, sign * units[unit]


def _said(columns: list[tuple[str, str, str, float]]) -> dict[str, str]:
    """Units that a file cannot state, as answers to `map`."""
    channels = {
        "t": "t",
        "x": "deflection",
        "v": "deflection_velocity",
        "F": "damper_force",
        "u": "duty",
    }
    return {
        channels[key]: f"{_plain(name)} [{unit}]"
        for key, name, unit, _ in columns
        if key in channels and unit
    }


def _plain(name: str) -> str:
    """A name that MATLAB takes."""
    return name.replace("ä", "ae")


def _text(
    delimiter: str, comma: bool
) -> Callable[[Path, dict[str, Array], dict[str, str], int], None]:
    """A writer of text tables; style: of `MARKS`, or a row of its own for the units."""

    def write(path: Path, table: dict[str, Array], units: dict[str, str], style: int) -> None:
        names = [MARKS[style if units[n] else 0].format(n, units[n]) for n in table]
        rows = [
            delimiter.join(f"{v:.{DECIMALS}g}" for v in row)
            for row in np.stack(list(table.values()), axis=1)
        ]
        rows = [row.replace(".", ",") for row in rows] if comma else rows
        head = [
            delimiter.join(names),
            *([delimiter.join(units[n] for n in table)] if style == 0 else []),
        ]
        path.with_suffix(".csv").write_text("\n".join([*head, *rows]) + "\n", encoding="utf-8")

    return write


def _tdms(path: Path, table: dict[str, Array], units: dict[str, str], style: int) -> None:
    """LabVIEW: units as properties of the channels."""
    del style
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(str(path.with_suffix(".tdms"))) as writer:
        writer.write_segment(
            [ChannelObject("Messung", n, y, {"unit_string": units[n]}) for n, y in table.items()]
        )


def _mat(path: Path, table: dict[str, Array], units: dict[str, str], style: int) -> None:
    """MATLAB: vectors without units."""
    del style, units
    from scipy.io import savemat

    savemat(path.with_suffix(".mat"), {_plain(n): y for n, y in table.items()})


WRITERS = {
    "semicolon": _text(";", comma=True), "comma": _text(",", comma=False), "tab": _text("\t", comma=False),
    "tdms": _tdms, "mat": _mat,
}  # fmt: skip

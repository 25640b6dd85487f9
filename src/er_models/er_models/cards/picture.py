"""The signature picture of an effect: what a standard experiment shows with it, without it, and of it alone."""

from __future__ import annotations

import numpy as np

from er_models.cards.panel import CHANGE, CYCLES, DT, SCALES, WITH, WITHOUT, Curve, Panel
from er_models.cards.ride import CAR_EXPERIMENT, RIDE_EXPERIMENT, ride_panels
from er_models.catalogue import CATALOGUE, Catalogue
from er_models.effect import Effect
from er_models.model import Array, Model
from er_models.prediction import Motion, motion, predict

SECONDS = 60.0
WARMING = 0.5
"""Rise of the measured temperature in the standard experiment [K/s]."""

EXPERIMENT = (
    "Sine of 2 Hz and 90 % of the stroke for 60 s; the picture shows its last second. The duty is 0.15, for effects "
    "of the actuation a square wave of 5 Hz between 0.05 and 0.3. The measured temperature rises by 0.5 K a second. "
    "Grey: damper without the effect; blue: with it, at the start that shows most; red: the difference."
)


def experiment(effect: Effect) -> str:
    """What an effect's picture shows, in words."""
    if effect.stage != "vehicle":
        return EXPERIMENT
    return CAR_EXPERIMENT if effect.name == "quarter_car" else RIDE_EXPERIMENT


def panels(effect: Effect, catalogue: Catalogue = CATALOGUE) -> tuple[Panel, ...]:
    """The panels of an effect's picture."""
    if effect.stage == "vehicle":
        return ride_panels(effect, catalogue)
    with_it, without, inputs = _forces(effect, catalogue)
    shown = slice(-round(CYCLES / 2.0 / DT) - 1, None)
    curves = [
        (without[shown], WITHOUT),
        (with_it[shown], WITH),
        ((with_it - without)[shown], CHANGE),
    ]
    x, v = 1e3 * inputs.x[shown], inputs.v[shown]
    return (
        Panel("velocity [m/s]", "force [N]", tuple(Curve(v, y, c) for y, c in curves)),
        Panel("deflection [mm]", "force [N]", tuple(Curve(x, y, c) for y, c in curves)),
    )


def _base(effect: Effect, catalogue: Catalogue) -> Model:
    """The damper an effect is shown on: the Guo damper, without what the effect is itself."""
    model = Model("card", {}, SCALES, catalogue=catalogue)
    for name in ("guo_yield", "passive", "response"):
        shared = catalogue[name].hooks.keys() & effect.hooks.keys()
        if effect.stage != "core" or not shared:
            model = model.with_effect(name)
    return model


def _experiment(effect: Effect) -> Motion:
    """The standard motion and duty."""
    t = np.arange(round(SECONDS / DT) + 1) * DT
    omega, amplitude = 2.0 * np.pi * 2.0, 0.9 * SCALES.deflection
    duty = np.full(t.size, 0.5 * SCALES.duty)
    if effect.stage == "actuation" or "response_time" in effect.hooks:
        duty = np.where(np.mod(5.0 * t + 1e-9, 1.0) < 0.5, 0.3, 0.05)
    sine, cosine = np.sin(omega * t), np.cos(omega * t)
    x, v, a = amplitude * sine, amplitude * omega * cosine, -amplitude * omega**2 * sine
    return motion(DT, x, v, duty, a, np.asarray(WARMING * t))


def _forces(effect: Effect, catalogue: Catalogue) -> tuple[Array, Array, Motion]:
    """Force [N] with the effect at the start that shows most, without it, and the experiment."""
    inputs, base = _experiment(effect), _base(effect, catalogue)
    without = predict(base, inputs)
    several = max(len(q.starts) for q in effect.parameters)
    forces = []
    for i in range(several):
        values = {q.name: base.start(effect.name, q.name, i) for q in effect.parameters}
        forces.append(predict(base.with_effect(effect.name, values), inputs))
    spread = [float(f"{np.std(force - without):.9g}") for force in forces]  # ties: the first start
    return forces[spread.index(max(spread))], without, inputs


def svg(effect: Effect, catalogue: Catalogue = CATALOGUE) -> str:
    """The picture as SVG, about 10 kB."""
    return drawing(panels(effect, catalogue))


def drawing(drawn: tuple[Panel, ...]) -> str:
    """Panels side by side as SVG; coordinates in tenths of a pixel."""
    width, height = 300, 220
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width * len(drawn)}" height="{height}" '
        f'font-family="sans-serif" font-size="11">',
        '<rect width="100%" height="100%" fill="#ffffff"/>',
    ]
    for i, panel in enumerate(drawn):
        parts.append(f'<g transform="translate({i * width} 0)">{_panel(panel, width, height)}</g>')
    return "\n".join([*parts, "</svg>", ""])


def _panel(panel: Panel, width: int, height: int) -> str:
    """Frame, zero lines, labels and curves of a panel."""
    left, top, right, bottom = 46, 10, width - 12, height - 34
    spans = [_span([getattr(c, axis) for c in panel.curves]) for axis in ("x", "y")]

    def place(x: Array, y: Array) -> tuple[Array, Array]:
        (x0, x1), (y0, y1) = spans
        across = left + (x - x0) / (x1 - x0) * (right - left)
        return across, bottom - (y - y0) / (y1 - y0) * (bottom - top)

    out = [
        f'<rect x="{left}" y="{top}" width="{right - left}" height="{bottom - top}" '
        'fill="none" stroke="#666666" stroke-width="0.8"/>'
    ]
    zero_x, zero_y = (float(z) for z in place(np.array(0.0), np.array(0.0)))
    if left < zero_x < right:
        out.append(_line(zero_x, top, zero_x, bottom))
    if top < zero_y < bottom:
        out.append(_line(left, zero_y, right, zero_y))
    out += [_curve(*place(c.x, c.y), c.colour) for c in panel.curves]
    (x0, x1), (y0, y1) = spans
    out += [
        _text(left, bottom + 13, "start", f"{x0:.3g}"),
        _text(right, bottom + 13, "end", f"{x1:.3g}"),
        _text(0.5 * (left + right), bottom + 26, "middle", panel.x_label),
        _text(left - 4, bottom, "end", f"{y0:.3g}"),
        _text(left - 4, top + 9, "end", f"{y1:.3g}"),
        f'<text transform="translate(14 {0.5 * (top + bottom):.1f}) rotate(-90)" '
        f'text-anchor="middle">{panel.y_label}</text>',
    ]
    return "\n".join(out)


def _span(values: list[Array]) -> tuple[float, float]:
    """Limits of an axis: those of the values, rounded outwards to two digits."""
    low, high = (float(f(np.concatenate(values))) for f in (np.min, np.max))
    step = 10.0 ** (np.floor(np.log10(max(abs(low), abs(high), high - low, 1e-12))) - 1.0)
    return float(np.floor(low / step - 1e-6) * step), float(np.ceil(high / step + 1e-6) * step)


def _curve(x: Array, y: Array, colour: str) -> str:
    """A polyline."""
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
    return f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1.3"/>'


def _line(x0: float, y0: float, x1: float, y1: float) -> str:
    """A thin line."""
    ends = f'x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}"'
    return f'<line {ends} stroke="#bbbbbb" stroke-width="0.7"/>'


def _text(x: float, y: float, anchor: str, text: str) -> str:
    """A label."""
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{text}</text>'

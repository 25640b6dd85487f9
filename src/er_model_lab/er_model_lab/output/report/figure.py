"""What a figure shows, free of any plotting library.

A figure is panels,
a panel is marks. The page's interactive plots (`report.live`) and the PNG and SVG
files (`report.still`) are drawn from the same description, so they cannot disagree.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from er_model_lab.output.report.palette import Stops
from er_model_lab.view import Array

Dash = Literal["solid", "dash", "dot"]


@dataclass(frozen=True, eq=False)
class Line:
    """A curve through x (n,), y (n,); NaN breaks it; below `grain` (0: unknown) is noise."""

    x: Array
    y: Array
    name: str
    colour: str
    width: float = 1.3
    dash: Dash = "solid"
    grain: float = 0.0


@dataclass(frozen=True, eq=False)
class Points:
    """Dots at x (n,), y (n,); colour is one colour, or values (n,) on the figure's scale."""

    x: Array
    y: Array
    name: str
    colour: str | Array
    size: float = 4.0
    alpha: float = 0.6


@dataclass(frozen=True, eq=False)
class Bars:
    """Bars at positions `at` (n,) from `base` to `base + size`; ends: error band (2, n)."""

    at: Array
    size: Array
    name: str
    colours: tuple[str, ...]
    base: Array | None = None
    ends: Array | None = None
    text: tuple[str, ...] = ()
    horizontal: bool = False
    width: float = 0.8


@dataclass(frozen=True, eq=False)
class Tiles:
    """A map: z (rows, columns) on the figure's scale over x_edges, y_edges; NaN stays empty."""

    x_edges: Array
    y_edges: Array
    z: Array


@dataclass(frozen=True)
class Band:
    """Horizontal band between two values of y."""

    low: float
    high: float
    name: str
    colour: str


@dataclass(frozen=True)
class Spans:
    """Shaded stretches of x."""

    stretches: tuple[tuple[float, float], ...]
    name: str
    colour: str


@dataclass(frozen=True)
class Level:
    """A straight line at one value of y, or of x when vertical."""

    value: float
    name: str
    colour: str
    dash: Dash = "dash"
    vertical: bool = False


@dataclass(frozen=True)
class Label:
    """A short text at x, along the top edge of its panel."""

    x: float
    text: str


Mark = Line | Points | Bars | Tiles | Band | Spans | Level | Label


@dataclass(frozen=True)
class Axis:
    """An axis: its label, range, and named ticks (position, text)."""

    label: str = ""
    span: tuple[float, float] | None = None
    ticks: tuple[tuple[float, str], ...] = ()
    log: bool = False


@dataclass(frozen=True)
class Panel:
    """Marks that share two axes."""

    marks: tuple[Mark, ...]
    x: Axis = field(default_factory=Axis)
    y: Axis = field(default_factory=Axis)
    title: str = ""


@dataclass(frozen=True)
class Scale:
    """A colour scale shared by all panels of a figure."""

    label: str
    low: float
    high: float
    stops: Stops


@dataclass(frozen=True)
class Figure:
    """Panels in reading order on a grid; alt says in words what is to be seen.

    height: of the whole figure [px]; heights: relative height per row; linked: all panels share
    the x axis, of which `span` is only what is seen first; width: of the drawing [px];
    interactive: whether the page offers a plot to zoom into, or a picture only.
    """

    name: str
    alt: str
    panels: tuple[Panel, ...]
    columns: int = 1
    height: int = 420
    heights: tuple[float, ...] = ()
    linked: bool = False
    scale: Scale | None = None
    width: int = 1000
    interactive: bool = True

    @property
    def rows(self) -> int:
        """Number of rows of the grid."""
        return -(-len(self.panels) // self.columns)

    @property
    def shares(self) -> tuple[float, ...]:
        """Height of each row as a share of all rows."""
        heights = self.heights or (1.0,) * self.rows
        return tuple(h / sum(heights) for h in heights)

"""What the page carries inside itself: scripts, data, pictures, the plotting library."""

from __future__ import annotations

import base64
import gzip
import json
from functools import cache
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path

from er_models.errors import InputError
from PIL import Image

COLOURS = 128
"""Colours of a picture inside the page: enough for its scales, a third of the size."""


def inflatable(text: str) -> str:
    """Text as base64 of gzip, for the browser's DecompressionStream; the same every time."""
    return base64.b64encode(gzip.compress(text.encode(), 6, mtime=0)).decode("ascii")


def compact(value: object) -> str:
    """JSON without spaces; `ValueError` for NaN, which browsers refuse."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False)


def picture(png: bytes, svg: bytes) -> str:
    """A picture as a data address: the SVG, or the PNG in few colours where that is smaller."""
    small = BytesIO()
    with Image.open(BytesIO(png)) as full:
        _in_few_colours(full.convert("RGB")).save(small, "PNG")
    if small.tell() < len(svg):
        return f"data:image/png;base64,{base64.b64encode(small.getvalue()).decode('ascii')}"
    return drawing(svg)


def _in_few_colours(full: Image.Image) -> Image.Image:
    """A picture with `COLOURS` colours: an octree finds them seven times as fast as the median cut."""
    few = full.quantize(COLOURS, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    # it lays the background's white among the nearly white of rounded edges, and the page beside it is white
    corner, colours = few.getpixel((0, 0)), few.getpalette()
    if colours and isinstance(corner, int):
        colours[3 * corner : 3 * corner + 3] = full.getpixel((0, 0))  # type: ignore[assignment]
        few.putpalette(colours)
    return few


def drawing(svg: bytes) -> str:
    """An SVG as a data address."""
    return f"data:image/svg+xml;base64,{base64.b64encode(svg).decode('ascii')}"


@cache
def plotting_library() -> str:
    """Plotly's script, compressed, from its package; `InputError` when it is not there."""
    spec = find_spec("plotly")
    origin = spec.origin if spec else None
    script = Path(origin).parent / "package_data" / "plotly.min.js" if origin else Path("plotly")
    if not script.is_file():
        raise InputError(script, "", "the script of the Python package plotly", "no such file")
    return inflatable(script.read_text(encoding="utf-8"))

"""Writes the report: one page that opens offline, and every figure as PNG and SVG beside it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from er_models.errors import InputError
from er_records.write import finished_only
from jinja2 import Environment, PackageLoader, StrictUndefined

from er_model_lab.output.report.embed import compact, inflatable, picture, plotting_library
from er_model_lab.output.report.figure import Figure
from er_model_lab.output.report.live import live
from er_model_lab.output.report.order import FLEET, SECTIONS
from er_model_lab.output.report.section import Section
from er_model_lab.output.report.still import still
from er_model_lab.output.text.units import percent
from er_model_lab.view import View

Stills = dict[str, tuple[bytes, bytes]]


def write_report(view: View, folder: Path, sections: Sequence[Section] | None = None) -> Path:
    """Write folder/index.html and folder/figures/<name>.png and .svg; returns the page.

    sections: what the page shows; by default all that `SECTIONS` make of the view.

    Everything is drawn before the first file is written. Figures of an earlier report in the same
    folder that this one does not have are removed, other files are left alone.

    Raises:
        InputError: When the folder cannot be written, or the plotting library is not installed.
    """
    if sections is None:
        sections = sections_of(view)
    stills = {f.name: still(f) for s in sections for f in s.figures}
    html = render(view, sections, stills)
    page = folder / "index.html"
    try:
        stale = _figures_of(page) - set(stills)
        for name, (png, svg) in stills.items():
            for suffix, content in ((".png", png), (".svg", svg)):
                with finished_only(folder / "figures" / f"{name}{suffix}") as part:
                    part.write_bytes(content)
        with finished_only(page) as part:
            part.write_text(html, encoding="utf-8")
        for name in stale:
            for suffix in (".png", ".svg"):
                (folder / "figures" / f"{name}{suffix}").unlink(missing_ok=True)
    except OSError as error:
        raise InputError(
            folder, "report", "a folder that can be written", error.strerror or str(error)
        ) from None
    return page


def sections_of(view: View) -> list[Section]:
    """All sections that have something to show."""
    every = SECTIONS if view.fleet is None else FLEET
    return [s for make in every if (s := make(view)) is not None]


def figures_of(view: View) -> dict[str, Figure]:
    """Every figure of the page, by name."""
    return {f.name: f for s in sections_of(view) for f in s.figures}


def render(view: View, sections: Sequence[Section], stills: Stills) -> str:
    """The page as text."""
    environment = Environment(
        loader=PackageLoader("er_model_lab.output.report"), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )  # fmt: skip
    environment.filters["percent"] = percent
    figures = [f for s in sections for f in s.figures]
    moving = [live(f) for f in figures if f.interactive]
    return environment.get_template("page.html.j2").render(
        view=view, sections=sections, names=" ".join(f.name for f in figures),
        picture={name: picture(*both) for name, both in stills.items()},
        style=_asset("page.css"), script=_asset("page.js"),
        tables=_asset("table.js") if any(s.template == "paged" for s in sections) else "",
        library=plotting_library() if moving else "",
        plots=inflatable(compact(moving)) if moving else "",
    )  # fmt: skip


def figures(view: View) -> list[Figure]:
    """Every figure of a view, in the order of the page."""
    return [f for make in SECTIONS if (s := make(view)) is not None for f in s.figures]


def _asset(name: str) -> str:
    """A file that travels inside the page."""
    return (Path(__file__).parent / "assets" / name).read_text(encoding="utf-8")


def _figures_of(page: Path) -> set[str]:
    """Names of the figures that an earlier report in this place wrote."""
    if not page.is_file():
        return set()
    head = page.read_text(encoding="utf-8", errors="replace")[:4000]
    found = re.search(r'<meta name="er-figures" content="([\w ]*)">', head)
    return set(found.group(1).split()) if found else set()

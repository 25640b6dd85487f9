"""What was checked of the data before anything was fitted, and what they cover."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from er_model_lab.output.report.figure import Axis, Bars, Figure, Panel, Scale, Tiles
from er_model_lab.output.report.palette import COVER, LEVELS, RESIDUAL
from er_model_lab.output.report.section import Section
from er_model_lab.output.text.findings import grouped, place_of
from er_model_lab.output.text.units import factor, labelled, short
from er_model_lab.output.text.verdict_text import joined, title_of
from er_model_lab.view import View


def section(view: View) -> Section | None:
    """Findings, maps of what is covered, and regions that are not; None where nothing was checked."""
    found = view.result.get("preflight")
    if not found:
        return None
    rows = [
        {
            "level": f["level"], "colour": LEVELS[f["level"]], "check": f["check"], "where": place_of(f, records),
            "found": f["found"], "expected": f["expected"], "remedy": f["remedy"],
        }
        for f, records in grouped(found["findings"])
    ]  # fmt: skip
    facts = {
        "first": [r for r in rows if r["level"] != "ok"],
        "others": [r for r in rows if r["level"] == "ok"],
        "cells": [_cell(view, c) for c in found["cells"] if not c["covered"]],
        "known_from": found["reach"]["known_from"],
    }
    figures = (_figure(found["maps"]),) if found["maps"] else ()
    return Section("preflight", "The data", figures, facts)


def _cell(view: View, c: Mapping[str, Any]) -> tuple[str, str, str]:
    """A region that is missing: what it is, how much there is, and what stays hidden."""
    have = f"{short(c['have'], 2)} of {short(c['need'], 2)} {c['unit']}"
    return c["region"], have, joined([title_of(view, e) for e in c["effects"]])


def _figure(maps: list[Mapping[str, Any]]) -> Figure:
    """Planes as maps of seconds on a logarithmic scale, lines as bars."""
    panels, most = [], 1.0
    for m in maps:
        x_edges = np.asarray(m["x_edges"]) * factor(m["x_unit"])
        seconds = np.asarray(m["seconds"], dtype=np.float64)
        x = Axis(labelled(m["x"], m["x_unit"]))
        if m["y"]:
            y_edges = np.asarray(m["y_edges"]) * factor(m["y_unit"])
            z = np.log10(np.where(seconds > 0.0, seconds, np.nan))
            most = max(most, float(np.nanmax(z)))
            tiles = Tiles(x_edges, y_edges, z)
            panels.append(Panel((tiles,), x, Axis(labelled(m["y"], m["y_unit"]))))
            continue
        at = 0.5 * (x_edges[1:] + x_edges[:-1])
        size = np.log10(1.0 + 100.0 * seconds[0])
        text = tuple(short(s, 2) if s > 0.0 else "" for s in seconds[0])
        bars = Bars(
            at,
            size,
            "",
            (RESIDUAL,) * at.size,
            text=text,
            width=0.9 * float(x_edges[1] - x_edges[0]),
        )
        top = Axis("seconds, logarithmic", (0.0, 1.25 * float(size.max())), ticks=((0.0, "0"),))
        panels.append(Panel((bars,), x, top))
    names = [f"{m['x']} and {m['y']}" if m["y"] else m["x"] for m in maps]
    alt = (
        f"How long the data stay in each part of {joined(names)}; empty parts were never visited."
    )
    scale = Scale("log10 of the time [s]", -2.5, most, COVER)
    rows = -(-len(panels) // 2)
    return Figure("coverage", alt, tuple(panels), 2, height=320 * rows + 20, scale=scale)

"""A layout of Foxglove (and Lichtblick): a tab a page, curves by header stamp."""

from __future__ import annotations

import json
from typing import Any

from er_bringup.integration.panels import COLOURS, PAGES, Page, Panel, full


def layout(namespace: str) -> str:
    """The layout's JSON for one corner."""
    panels: dict[str, Any] = {}
    tabs = []
    for page in PAGES:
        ids = [_plot(panels, page, panel, namespace) for panel in page.panels]
        tabs.append({"title": page.title, "layout": _above(ids)})
    panels["Tab!corner"] = {"activeTabIdx": 0, "tabs": tabs}
    document = {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": "Tab!corner",
    }
    return json.dumps(document, indent=1) + "\n"


def _plot(panels: dict[str, Any], page: Page, panel: Panel, namespace: str) -> str:
    name = f"Plot!p{PAGES.index(page)}{page.panels.index(panel)}"
    panels[name] = {
        "title": panel.title,
        "paths": [
            {
                "value": f"{full(namespace, curve.topic)}.{curve.field}",
                "enabled": True,
                "timestampMethod": "headerStamp",
                "color": colour,
            }
            for curve, colour in zip(panel.curves, COLOURS, strict=False)
        ],
        "showXAxisLabels": True,
        "showYAxisLabels": True,
        "showLegend": True,
        "legendDisplay": "floating",
        "showPlotValuesInLegend": True,
        "isSynced": True,
        "xAxisVal": "timestamp",
        "followingViewWidth": 10,
    }
    return name


def _above(ids: list[str]) -> Any:
    """Panels above one another, each of the same height."""
    if len(ids) == 1:
        return ids[0]
    return {
        "direction": "column",
        "first": ids[0],
        "second": _above(ids[1:]),
        "splitPercentage": 100.0 / len(ids),
    }

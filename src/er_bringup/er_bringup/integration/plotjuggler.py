"""A layout of PlotJuggler 3: a tab a page. Whose stamps count is asked by its dialogue, which no layout answers."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from er_bringup.integration.panels import COLOURS, PAGES, Page, Panel, full

SHOWN = 10.0
"""Time that is shown at first [s]."""
READERS = ("DataLoad ROS2 bags", "ROS2 Topic Subscriber")
"""Its plugins that read messages: without a word they go by the time of arrival."""
SETTINGS = {
    "use_header_stamp": "true",
    "discard_large_arrays": "true",
    "max_array_size": "100",
    "boolean_strings_to_number": "true",
    "remove_suffix_from_strings": "true",
}
"""Of each: all that it looks for, since it takes what is not there as false."""


def layout(namespace: str) -> str:
    """The layout's XML for one corner."""
    root = ET.Element("root")
    tabs = ET.SubElement(root, "tabbed_widget", {"parent": "main_window", "name": "Main Window"})
    for page in PAGES:
        _tab(tabs, page, namespace)
    ET.SubElement(tabs, "currentTabIndex", index="0")
    ET.SubElement(root, "use_relative_time_offset", enabled="1")
    plugins = ET.SubElement(root, "Plugins")
    for reader in READERS:
        plugin = ET.SubElement(plugins, "plugin", ID=reader)
        for name, value in SETTINGS.items():
            ET.SubElement(plugin, name, value=value)
    ET.indent(root, " ")
    return f"<?xml version='1.0' encoding='UTF-8'?>\n{ET.tostring(root, encoding='unicode')}\n"


def _tab(tabs: ET.Element, page: Page, namespace: str) -> None:
    count = len(page.panels)
    tab = ET.SubElement(tabs, "Tab", tab_name=page.title, containers="1")
    sizes = ";".join([f"{1.0 / count:.6f}"] * count)
    splitter = ET.SubElement(
        ET.SubElement(tab, "Container"),
        "DockSplitter",
        orientation="-",
        sizes=sizes,
        count=str(count),
    )
    for panel in page.panels:
        _plot(ET.SubElement(splitter, "DockArea", name=panel.title), panel, namespace)


def _plot(area: ET.Element, panel: Panel, namespace: str) -> None:
    plot = ET.SubElement(
        area, "plot", mode="TimeSeries", style="Lines", flip_x="false", flip_y="false"
    )
    ET.SubElement(
        plot, "range", left="0.000000", right=f"{SHOWN:.6f}", bottom="-1.000000", top="1.000000"
    )
    ET.SubElement(plot, "limitY")
    for curve, colour in zip(panel.curves, COLOURS, strict=False):
        ET.SubElement(
            plot, "curve", name=f"{full(namespace, curve.topic)}/{curve.field}", color=colour
        )

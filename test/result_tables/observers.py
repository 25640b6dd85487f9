"""Observers beside Kalman filters and the thesis: `study observers`, and over classes of roads `study classes`."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from er_studies.given_out import table

from test.result_tables.stored import Run

WORSE = 1.05
"""Error of the fused observer, over the best of its rivals, above which it is shown bold."""
OBSERVERS = (
    "src/er_models/er_models",
    "src/er_observers/er_observers",
    "src/er_studies/er_studies/observers",
)


_KEPT = (
    "scenario", "begin", "end", "table", "roads", "published", "nrmse", "nrmse_without_start_phase", "settled", "floor",
    "best_of_ours_less_best_peer",
)  # fmt: skip
"""What is stored of a window of a scenario."""


def _windows(written: dict[str, Any]) -> list[dict[str, Any]]:
    """Every window of every scenario."""
    return [{name: window[name] for name in _KEPT} for window in written["windows"]]


CLASSES = Run("classes", "study classes", "observer_comparison.md", OBSERVERS)
DRIVES = Run("drives", "study observers", "observer_comparison.md", OBSERVERS, _windows)
_SHOWN = ("20 um, A", "20 um, C", "20 um, E", "100 um, C", "200 um, A", "200 um, E")
_CASES = {
    "healthy": "healthy", "f1": "f1 = 0.5", "f2": "f2 = 0.6", "f2_appears": "f2 appears",
    "friction": "friction 1 N", "heavy": "20 % more mass",
}  # fmt: skip
_ALONE = {
    "nlpv_polytopic_alone": "polytopic", "nlpv_gridding_alone": "gridding", "unified_alone": "unified",
    "ekf": "EKF, 4 states", "ukf": "UKF, 4 states", "ekf_5": "EKF, 5 states", "ukf_5": "UKF, 5 states",
}  # fmt: skip
_FAULTS = {
    "f1_appears": ", half the field lost", "f2_appears": ", 60 % of the oil's force left",
    "f3_appears": ", 60 % of the fluid's force left", "all_appears": ", 80 % of each",
    "f2_appears_heavy": ", 20 % more mass", "f2_appears_light": ", 10 % less", "f2_appears_friction": ", 1 N",
    "f2_appears_heavy_friction": "",
}  # fmt: skip
_OURS = {"nlpv_polytopic": "polytopic", "nlpv_gridding": "gridding", "unified": "unified"}
_ESTIMATORS = {**_OURS, "ekf": "EKF", "ukf": "UKF"}
_THREE = "thesis: polytopic / gridding / unified"
_RATIO = "worst of ours / better peer"
_APART = ("faults/", "payload/")
"""Scenarios that have a table, or a page, of their own."""
_BELIEVED = (
    "wrong_sensors_delay",
    "hidden_effects/sprung_mass_error",
    "hidden_effects/asymmetric_damping",
)


def _percent(share: float, digits: int = 3) -> str:
    return f"{100.0 * share:.{digits}f}"


def with_deflection(values: dict[str, dict[str, float]]) -> str:
    """The fused observer beside the balance and the unified observer alone."""
    rows = []
    for drive in _SHOWN:
        found = {case: values[f"{drive}, {case}"] for case in _CASES}
        alone = {case: values[f"20 um{drive[drive.index(',') :]}, {case}"] for case in _CASES}
        rivals = {
            "direct balance": {case: found[case]["balance"] for case in _CASES},
            "alone": {case: alone[case]["unified_alone"] for case in _CASES},
        }
        fused = []
        for case in _CASES:
            own, best = found[case]["fused"], min(r[case] for r in rivals.values())
            fused.append(_bold(_percent(own), own > WORSE * best))
        rows.append([drive, "fused", *fused])
        rows += [["", n, *(_percent(r[case]) for case in _CASES)] for n, r in rivals.items()]
    return table(["noise, class", "estimate", *_CASES.values()], rows)


def without_deflection(values: dict[str, dict[str, float]]) -> str:
    """The three observers beside filters of the same four states, and of a fifth for a coloured road."""
    rows = [
        [road, *(_percent(values[f"20 um, {road}, healthy"][name]) for name in _ALONE)]
        for road in "ABCDE"
    ]
    return table(["class", *_ALONE.values()], rows)


def with_faults(windows: list[dict[str, Any]]) -> str:
    """Observers and filters on two accelerometers once a fault has appeared."""
    last = {window["scenario"]: window["nrmse"] for window in windows}
    rows = [
        [f"`{name}`{what}", *_errors(last[f"faults/{name}"])] for name, what in _FAULTS.items()
    ]
    return table(["", *_ESTIMATORS.values()], rows)


def beside_the_thesis(windows: list[dict[str, Any]]) -> str:
    """Windows of which the thesis prints a figure."""
    rows = [
        [*_thesis(window), str(window["roads"]), _published(window), *_errors(window["nrmse"])]
        for window in _of_the_thesis(windows)
    ]
    head = ["thesis", "scenario", "roads", _THREE, *_ESTIMATORS.values()]
    return table(head, rows)


def without_start_phase(windows: list[dict[str, Any]]) -> str:
    """The proved gains alone from the first sample on; bold where they do not reach the thesis's own figure."""
    rows = []
    others = [w for w in windows if w["begin"] == 0.0 and not w["table"]]
    for window in (*_of_the_thesis(windows), *others):
        alone = window["nrmse_without_start_phase"]
        if alone:
            cells = [
                _bold(_percent(alone[n], 2), alone[n] >= window["published"].get(n, math.inf))
                for n in _OURS
            ]
            rows.append([*_thesis(window), _published(window) if window["table"] else "", *cells])
    return table(["thesis", "scenario", _THREE, *_OURS.values()], rows)


def from_the_start(windows: list[dict[str, Any]]) -> str:
    """Whole drives, the start among them, and when the error has settled."""
    rows = []
    for window in _longest(windows):
        settled = window["settled"]
        ours = _seconds(max((settled[n] for n in _OURS), key=_late))
        times = [ours, *(_seconds(settled[n]) for n in ("ekf", "ukf"))]
        rows.append([*_compared(window), *times])
    head = ["scenario, from the start on", "roads", *_ESTIMATORS.values(), _RATIO]
    return table([*head, "settled: ours, latest", "EKF", "UKF"], rows)


def once_running(windows: list[dict[str, Any]]) -> str:
    """From 2 s on."""
    rows = [
        _compared(w) for w in windows if w["begin"] == 2.0 and not w["scenario"].startswith(_APART)
    ]
    return table(["scenario, from 2 s on", "roads", *_ESTIMATORS.values(), _RATIO], rows)


def where_filters_win(windows: list[dict[str, Any]]) -> str:
    """Drives on which the believed force itself is wrong: the paired difference, and what the belief alone leaves."""
    by = {window["scenario"]: window for window in windows}
    rows = []
    for name in _BELIEVED:
        errors = by[name]["nrmse"]
        low = [_range([errors[e] for e in group]) for group in (_OURS, ("ekf", "ukf"))]
        middle, least, most = (100.0 * x for x in by[name]["best_of_ours_less_best_peer"])
        less = f"{middle:.2f} ({least:.2f} to {most:.2f})"
        rows.append([f"`{name}`", less, *low, _percent(by[name]["floor"], 2)])
    head = ["scenario", "best of ours less best filter", "errors of ours", "errors of the filters"]
    return table([*head, "left by the wrong belief alone"], rows)


def _of_the_thesis(windows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """In the order of the thesis's tables."""
    return sorted((w for w in windows if w["table"]), key=lambda w: w["table"])


def _longest(windows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Of each scenario the longest window from its start on."""
    longest: dict[str, dict[str, Any]] = {}
    for window in windows:
        known = longest.get(window["scenario"], window)
        if window["begin"] == 0.0 and window["end"] >= known["end"]:
            longest[window["scenario"]] = window
    return list(longest.values())


def _thesis(window: dict[str, Any]) -> list[str]:
    time = f"{window['begin']:g}-{window['end']:g} s"
    return [window["table"] or "", f"`{window['scenario']}`, {time}"]


def _published(window: dict[str, Any]) -> str:
    found = (window["published"].get(name) for name in _OURS)
    return " / ".join("-" if share is None else _percent(share, 2) for share in found)


def _errors(errors: dict[str, float]) -> list[str]:
    return [_percent(errors[name], 2) for name in _ESTIMATORS]


def _compared(window: dict[str, Any]) -> list[str]:
    """Errors, and the worst of ours over the better filter."""
    errors = window["nrmse"]
    ratio = max(errors[n] for n in _OURS) / min(errors[n] for n in ("ekf", "ukf"))
    return [f"`{window['scenario']}`", str(window["roads"]), *_errors(errors), f"{ratio:.2f}"]


def _range(shares: list[float]) -> str:
    least, most = _percent(min(shares), 2), _percent(max(shares), 2)
    return least if least == most else f"{least} to {most}"


def _late(seconds: float | None) -> float:
    return math.inf if seconds is None else seconds


def _seconds(seconds: float | None) -> str:
    return "never" if seconds is None else f"{seconds:.2f} s"


def _bold(text: str, wanted: bool) -> str:
    return f"**{text}**" if wanted else text


TABLES: dict[str, tuple[Run, Callable[[Any], str]]] = {
    "with faults": (DRIVES, with_faults),
    "beside the thesis": (DRIVES, beside_the_thesis),
    "without start phase": (DRIVES, without_start_phase),
    "from the start": (DRIVES, from_the_start),
    "once running": (DRIVES, once_running),
    "where filters win": (DRIVES, where_filters_win),
    "with deflection": (CLASSES, with_deflection),
    "without deflection": (CLASSES, without_deflection),
}

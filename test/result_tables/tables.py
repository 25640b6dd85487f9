"""The tables: which stored run each is made of, and how."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from test.blind_score.tables import table
from test.result_tables.measured import MTS, PISTON, SHAKING, improved
from test.result_tables.stored import Run

WORSE = 1.05
"""Error of the fused observer, over the best of its rivals, above which it is shown bold."""
OBSERVERS = (
    "src/er_models/er_models",
    "src/er_observers/er_observers",
    "src/er_studies/er_studies/observers",
)


def _last_windows(written: dict[str, Any]) -> dict[str, dict[str, float]]:
    """NRMSE of each estimator in the last window of each scenario."""
    return {window["scenario"]: window["nrmse"] for window in written["windows"]}


CLASSES = Run("classes", "study classes", "observer_comparison.md", OBSERVERS)
FAULTS = Run(
    "faults",
    "study observers faults payload --seeds 1",
    "observer_comparison.md",
    OBSERVERS,
    _last_windows,
)
ALARMS = Run("alarms", "study alarms", "page.md", ("src/er_model_lab/er_model_lab/monitor",))
RUNS = {run.name: run for run in (CLASSES, FAULTS, MTS, SHAKING, PISTON, ALARMS)}
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
_ESTIMATORS = {
    "nlpv_polytopic": "polytopic", "nlpv_gridding": "gridding", "unified": "unified", "ekf": "EKF", "ukf": "UKF",
}  # fmt: skip


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
            fused.append(f"**{_percent(own)}**" if own > WORSE * best else _percent(own))
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


def with_faults(values: dict[str, dict[str, float]]) -> str:
    """Observers and filters on two accelerometers once a fault has appeared."""
    rows = [
        [f"`{name}`{what}", *(_percent(values[f"faults/{name}"][e], 2) for e in _ESTIMATORS)]
        for name, what in _FAULTS.items()
    ]
    return table(["", *_ESTIMATORS.values()], rows)


def false_alarms(values: dict[str, Any]) -> str:
    """How often the monitor's test calls in vain, and how soon it finds a change."""
    head = [
        "error",
        f"false alarms in {values['hours']:g} h",
        "growth by 30 % is found after: median",
        "95 %",
    ]
    rows = [
        [name, f"{kind['alarms']:g}", f"{kind['median']:.1f} s", f"{kind['late']:.1f} s"]
        for name, kind in values["kinds"].items()
    ]
    return table(head, rows)


TABLES: dict[str, tuple[Run, Callable[[Any], str]]] = {
    "alarms": (ALARMS, false_alarms),
    "with faults": (FAULTS, with_faults),
    "with deflection": (CLASSES, with_deflection),
    "without deflection": (CLASSES, without_deflection),
    **{run.name: (run, partial(improved, run)) for run in (MTS, SHAKING, PISTON)},
}

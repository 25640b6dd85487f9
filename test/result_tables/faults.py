"""The fault estimator on random drives, beside its bound and other estimators."""

from __future__ import annotations

from test.result_tables.given import Tables, given

CODE = (
    "src/er_models/er_models",
    "src/er_observers/er_observers/faults",
    "src/er_studies/er_studies/faults",
)


def _run(name: str, command: str, *tables: str) -> Tables:
    return given(name, f"study {command}", "fault_estimator.md", CODE, *tables)


TABLES: Tables = {
    **_run(
        "fault_statistics",
        "fault_statistics --number 40 --seed 1",
        "drives without a fault",
        "drives with a fault",
    ),
    **_run(
        "fault_statistics_200",
        'fault_statistics healthy "f1 = 0.5" "f2 = 0.6" "f3 = 0.6" --number 200 --seed 14',
        "two hundred drives without a fault",
        "two hundred drives with a fault",
    ),
    **_run(
        "fault_trials",
        "fault_trials --number 30 --seed 2",
        "fault trials",
        "trials without a fault",
        "hidden effects",
    ),
    **_run("fault_rivals", "fault_trials --rivals --number 12 --seed 2", "fault rivals"),
}

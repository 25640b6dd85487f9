"""What `improve` alone makes of the measured sets, step by step."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from er_models.catalogue import CATALOGUE
from er_studies.given_out import table

from test.result_tables.given import given
from test.result_tables.stored import Run

CODE = ("src/er_models/er_models", "src/er_records/er_records", "src/er_model_lab/er_model_lab")
_LAST = "--model config/dampers/inove_guo.yaml --out better.yaml --seed 1"


def _steps(written: dict[str, Any]) -> dict[str, Any]:
    """Steps, result and verdict of an improvement."""
    kept = {name: written[name] for name in ("steps", "final_verdict", "interrupted")}
    return {**kept, "held_out": written["rmse_after"]["held_out"]}


def _improve(name: str, data: str) -> Run:
    return Run(f"improve_{name}", f"lab improve {data} {_LAST}", "measured.md", CODE, _steps)


MTS = _improve("mts", "mts/train --hold-out mts/held_out_sine")
SHAKING = _improve("shaking", "shaking")
PISTON = _improve("piston", "piston")
FORCE = {MTS.name: 721.0, SHAKING.name: 352.0, PISTON.name: 9.45}
"""Standard deviation of the force in the runs held out [N]."""


def _share(step: dict[str, Any], name: str) -> str:
    return f"{100.0 * step[name]:.0f} %" if step.get(name) is not None else ""


def improved(run: Run, values: dict[str, Any]) -> str:
    """Error on the runs held out after each effect, and how steadily blocks and runs speak for it."""

    def error(newtons: float) -> list[str]:
        return [f"{newtons:.3g} N", f"{newtons / FORCE[run.name]:.3f}"]

    rows = []
    for step in values["steps"]:
        together = (step["added"] or "").split(" + ")  # of effects that help together, one step
        titles = " and ".join(CATALOGUE[name].title for name in together if name)
        title = f"+ {titles}" if titles else "start model, refitted"
        sizes = [f"{step[key]:.3g} N" if key in step else "" for key in ("evidence", "threshold")]
        shares = [_share(step, key) for key in ("blocks", "records")]
        rows.append([title, *error(step["rmse_held_out"]), *sizes, *shares])
    end = f"result: `{values['final_verdict']}`" + ", interrupted" * values["interrupted"]
    rows.append([end, *error(values["held_out"]), "", "", "", ""])
    head = ["model", "held out", "over std", "size", "least", "blocks better", "runs better"]
    return table(head, rows)


TABLES: dict[str, tuple[Run, Callable[[Any], str]]] = {
    run.name: (run, partial(improved, run)) for run in (MTS, SHAKING, PISTON)
} | given(
    "reach_piston",
    "study reach piston --model piston1.yaml",
    "measured.md",
    CODE,
    "reach of the piston",
)

"""The model lab: compare a damper model with measurements, see where it fails, learn what is missing, add it.

    import er_model_lab as lab

    data = lab.load("run1.mcap", "run2.csv")        # or from_arrays(...), from_frame(...)
    model = lab.load_model("inove_guo")             # a shipped name, or a path
    result = lab.diagnose(data, model)
    result.verdict, result.effects, result.rmse
    better = lab.improve(data, model).model

SI units throughout: m, m/s, m/s2, N, s; duty 0 to 1. Deflection and damper force are positive in extension. Nothing
here needs ROS. A plot library is imported when a figure or a report is asked for, and not before.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from er_models.errors import ErError, InputError, MissingChannel, UnknownName
    from er_models.files import save_model
    from er_models.version import __version__
    from er_records.dataset import Dataset
    from er_records.in_memory import from_arrays, from_frame
    from er_records.record import Record

    from er_model_lab.diagnosis.rule import Rule
    from er_model_lab.fleets.fleet import fleet
    from er_model_lab.results.fleet import FleetResult
    from er_model_lab.results.records import CandidateResult, Errors, Parameter, Step
    from er_model_lab.results.result import (
        CheckResult,
        ComparisonResult,
        DiagnosisResult,
        IdentificationResult,
        PlanResult,
    )
    from er_model_lab.verbs.add import add, refit
    from er_model_lab.verbs.check import check
    from er_model_lab.verbs.compare import compare
    from er_model_lab.verbs.diagnose import diagnose
    from er_model_lab.verbs.export import ExportResult, export
    from er_model_lab.verbs.identify import identify
    from er_model_lab.verbs.improve import improve
    from er_model_lab.verbs.load import load, load_model
    from er_model_lab.verbs.map import map
    from er_model_lab.verbs.new import models, new
    from er_model_lab.verbs.plan import plan
    from er_model_lab.work import Cancelled, Leader

_HOME = {
    "ErError": "er_models.errors", "InputError": "er_models.errors", "MissingChannel": "er_models.errors",
    "UnknownName": "er_models.errors", "save_model": "er_models.files", "__version__": "er_models.version",
    "Rule": "er_model_lab.diagnosis.rule", "Dataset": "er_records.dataset",
    "Record": "er_records.record",
    **dict.fromkeys(("from_arrays", "from_frame"), "er_records.in_memory"),
    **dict.fromkeys(
        ("CandidateResult", "Errors", "Parameter", "Step"), "er_model_lab.results.records"
    ),
    **dict.fromkeys(
        ("CheckResult", "ComparisonResult", "DiagnosisResult", "IdentificationResult", "PlanResult"),
        "er_model_lab.results.result",
    ),
    **dict.fromkeys(("load", "load_model"), "er_model_lab.verbs.load"), "ExportResult": "er_model_lab.verbs.export",
    "refit": "er_model_lab.verbs.add",
    "fleet": "er_model_lab.fleets.fleet", "FleetResult": "er_model_lab.results.fleet",
    **dict.fromkeys(("Cancelled", "Leader"), "er_model_lab.work"),
    **dict.fromkeys(("models", "new"), "er_model_lab.verbs.new"),
    **{
        verb: f"er_model_lab.verbs.{verb}"
        for verb in ("add", "check", "compare", "diagnose", "export", "identify", "improve", "map", "plan")
    },
}  # fmt: skip
"""Where each name lives: it is imported when it is first asked for."""

__all__ = [
    "Cancelled", "CandidateResult", "CheckResult", "ComparisonResult", "Dataset", "DiagnosisResult", "ErError",
    "Errors", "ExportResult", "FleetResult", "IdentificationResult", "InputError", "Leader", "MissingChannel",
    "Parameter", "PlanResult", "Record", "Rule", "Step", "UnknownName", "__version__", "add", "check", "compare",
    "diagnose", "export", "fleet", "from_arrays", "from_frame", "identify", "improve", "load", "load_model", "map",
    "models", "new", "plan", "refit", "save_model",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    """A name of the interface, from its home."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})

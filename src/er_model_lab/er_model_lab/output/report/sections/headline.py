"""The verdict as a banner in plain words, and the error in newtons."""

from __future__ import annotations

from collections.abc import Mapping

from er_model_lab.output.report.palette import AFTER, VERDICT
from er_model_lab.output.report.section import Section
from er_model_lab.output.text.verdict_text import beyond_noise, verdict_sentence, verdict_title
from er_model_lab.view import View


def section(view: View) -> Section:
    """Always there: every command has something to say."""
    result = view.result
    return Section(
        "headline",
        "Result",
        facts={
            "title": verdict_title(view),
            "sentence": verdict_sentence(view),
            "line": view.headline,
            "colour": VERDICT.get(str(result.get("verdict")), AFTER),
            "data": "held-out data" if isinstance(result.get("rmse"), Mapping) else "all data",
            "model": "The model before anything is added, refitted"
            if result.get("steps")
            else "The model as given",
            "share": beyond_noise(view),
            "incomplete": result.get("complete") is False,
            "noted": bool(view.notes or view.provenance),
            "reasons": tuple(result.get("reasons") or ()),
        },
    )

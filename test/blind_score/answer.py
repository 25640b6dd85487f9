"""What the lab answers to one case, whoever made it: its result, its refusal or its crash, and the time."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from er_models.errors import ErError

SHOWN = 4
"""Candidates noted with their evidence."""


def said(result: dict[str, Any]) -> dict[str, Any]:
    """What matters of the lab's result."""
    shown = result["candidates"][:SHOWN]
    return {
        "verdict": result["verdict"],
        "final_verdict": result["final_verdict"],
        "names": result["effects"],
        "alternatives": result["alternatives"],
        "floor": result["noise_floor"],
        "before": result["rmse"],
        "after": result["rmse_after"],
        "explainable": result["explainable"],
        "explained": result["explained"],
        "unexplained": result["unexplained"]["share"],
        "largest": max(
            (c["evidence"] for c in result["candidates"] if "threshold" in c), default=0.0
        ),
        "least_p": min(
            (c["p_value"] for c in result["candidates"] if "threshold" in c), default=1.0
        ),
        "threshold": next(
            (c["threshold"] for c in result["candidates"] if "threshold" in c), None
        ),
        "candidates": [[c["effect"], c["evidence"], c["p_value"]] for c in shown],
        "parameters": {c["effect"]: c["parameters"] for c in shown if c["status"] == "present"},
    }


def timed(work: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """What the lab answers, and how long it took [s]."""
    began = time.monotonic()
    return {**guarded(work), "time": round(time.monotonic() - began, 2)}


def guarded(work: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """What the lab answers; its refusal, or its crash, is an answer too."""
    try:
        return work()
    except ErError as error:
        return {"failed": " ".join(str(error).split())}
    except (ArithmeticError, ValueError, AssertionError) as error:
        return {"failed": f"{type(error).__name__}: {error}"}

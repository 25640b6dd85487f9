"""A planned run that the running graph is asked to drive: what will move, and what has come of it. Pure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from er_models.interlude import GO_OVER
from er_models.program import Program, times

from er_model_lab.output.text.units import short


@dataclass(frozen=True)
class PlannedRun:
    """A run with the node that drives it, why none does, and when the answer came on the drive's clock [s]."""

    program: Program
    node: str = ""
    reason: str = ""
    begin: float = math.nan

    @property
    def accepted(self) -> bool:
        """Whether a node drives it, or has."""
        return bool(self.node) and not self.reason

    def driven(self, now: float) -> float:
        """How much of it has been driven at a time of the drive [s]; below 0 while the road goes over."""
        return now - self.begin - GO_OVER

    def under_way(self, now: float) -> bool:
        """Whether it is being driven, with the ways there and back."""
        return self.accepted and self.driven(now) < self.program.duration + GO_OVER

    def says(self, now: float) -> str:
        """Where it is, in a line."""
        who = self.node or "no node drives it"
        if self.reason:
            return f"{who}: {self.reason}"
        if not self.node:
            return "the graph is asked to drive it ..."
        if not self.under_way(now):
            return f"{who} has driven it; its own drive goes on"
        done = min(max(self.driven(now), 0.0), self.program.duration)
        return f"{who} drives it: {done:.0f} of {self.program.duration:.0f} s"


def moves(program: Program, told: dict[str, Any]) -> list[str]:
    """What a planned run moves, and how far, for who is to say yes; told: what `plan` found."""
    used, limits = told["programs"][0]["used"], told["limits"]
    stroke, velocity, duty = (
        f"{short(unit * used[name], 3)} of {short(unit * limits[name], 3)}"
        for name, unit in (("stroke", 1e3), ("velocity", 1.0), ("duty", 1.0))
    )
    road = np.abs(program.heights(times(program.duration, limits["dt"]))).max()
    return [
        f"Road: up to {short(1e3 * road, 3)} mm to each side for {program.duration:g} s. It goes over from that of the "
        f"drive, and back, within {GO_OVER:g} s.",
        f"Damper, as the planner expects it: up to {stroke} mm and {velocity} m/s.",
        f"Duty: the run's, up to {duty}; what a controller says does not act meanwhile.",
        "The node drives it ahead within the limits of its own rig first. A hardware bridge moves the road "
        "only with road:=program; else the duty alone is the run's.",
    ]

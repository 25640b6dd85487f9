"""Pieces of a program, and programs made of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from er_models.program import Program

from er_model_lab.planning.limits import Limits

FADE = 0.5
"""Time in which each piece comes and goes [s]."""
Spec = Mapping[str, Any]


@dataclass(frozen=True)
class Segment:
    """A road and a duty together for some seconds.

    level: share of the tightest limit of the motion that it shall use; factor: what scales the
    road to that; tones: distinct frequencies of the motion, 3 standing for many.
    """

    road: Spec
    duty: Spec
    seconds: float
    level: float = 1.0
    factor: float = 1.0
    tones: tuple[float, ...] = ()

    @property
    def moves(self) -> bool:
        """Whether the road is not flat."""
        return bool(self.road["kind"] != "flat")

    def scaled(self, ratio: float) -> Segment:
        """The same with its road higher by a ratio, of four digits."""
        return replace(self, factor=float(f"{self.factor * ratio:.4g}"))

    def sized(self) -> dict[str, Any]:
        """The road with its factor, which goes into the amplitude where there is one."""
        road = dict(self.road)
        if "amplitude" in road:
            road["amplitude"] = float(f"{self.factor * road['amplitude']:.4g}")
        elif self.moves:
            road["factor"] = self.factor
        return road


def program_of(
    segments: Sequence[Segment], limits: Limits, *, seed: int, car: bool, once: bool = False
) -> Program:
    """The segments one after another, again and again until the duration is over.

    once: only once through, whatever the duration.
    """
    roads = [{**s.sized(), "seconds": s.seconds} for s in segments]
    duties = [{**s.duty, "seconds": s.seconds} for s in segments]
    seconds = sum(s.seconds for s in segments)
    return Program(
        road={"kind": "sequence", "fade": FADE, "parts": roads},
        duty={"kind": "sequence", "parts": duties},
        duration=seconds if once else limits.duration,
        seed=seed,
        moves="wheel" if car else "damper",
    )


def in_words(segment: Segment) -> str:
    """The piece as a reader would call it."""
    return f"{_road(segment)}, {_duty(segment.duty)}"


def _road(segment: Segment) -> str:
    """The road in words."""
    r = segment.sized()
    height = r.get("amplitude", 1.0)
    if r["kind"] in ("sine", "triangle"):
        shape = "sine" if r["kind"] == "sine" else "ramps"
        return f"{shape} {r['frequency']:.3g} Hz {1e3 * height:.3g} mm"
    if r["kind"] == "chirp":
        return f"sweep {r['f0']:.2g} to {r['f1']:.2g} Hz {1e3 * height:.3g} mm"
    if r["kind"] == "multisine":
        return f"{len(r['frequencies'])} sines {r['frequencies'][0]:.2g} to {r['frequencies'][-1]:.2g} Hz"
    return {"flat": "standstill", "iso8608": "random road"}.get(str(r["kind"]), str(r["kind"]))


def _duty(d: Spec) -> str:
    """The duty in words."""
    if d["kind"] == "constant":
        return f"duty {d['level']:.3g}"
    if d["kind"] == "square":
        return f"duty square {d['low']:.2g}/{d['high']:.2g} {d['frequency']:.2g} Hz"
    if d["kind"] == "sine":
        return f"duty sine {d['frequency']:.2g} Hz"
    if d["kind"] == "stairs":
        return f"duty stairs of {d['hold']:.2g} s"
    return "duty random steps"

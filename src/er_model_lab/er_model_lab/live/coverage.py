"""What a drive has not shown yet, and what to do about it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from er_models.model import Array, Model
from er_records.record import Record

from er_model_lab.preflight.check import reach_for
from er_model_lab.preflight.excitation import CELLS, counts, course_of, reach_of
from er_model_lab.preflight.wild import bridged

DO = {
    "slow": "drive gently: the damper is to creep, below 15 % of its speed",
    "fast_extension": "drive a rough stretch: fast extension is missing",
    "fast_compression": "drive a rough stretch: fast compression is missing",
    "far_extension": "drive a bump: the damper is to extend far",
    "far_compression": "drive a bump: the damper is to compress far",
    "reversals": "keep moving: the motion is to turn more often",
    "low_duty": "set the duty to its least for some seconds",
    "small_duty": "hold a small duty, up to a fifth of the range",
    "high_duty": "hold a high duty for some seconds",
    "duty_levels": "hold the duty, half a second and more, at three levels",
    "duty_rises": "step the duty up while the damper moves",
    "duty_falls": "step the duty down while the damper moves",
    "fast_high_duty": "drive a rough stretch at high duty",
    "far_high_duty": "drive a bump at high duty",
    "minutes": "go on: heat and ageing need a minute",
    "load_change": "work the damper hard for a while, then gently: heat shows in the change",
    "warming": "warm the damper up by 5 K (with a temperature channel)",
}
"""What fills each region of `CELLS`."""
LATER = ("minutes", "load_change", "warming")
"""Regions that effects of heat and age need: a first verdict does not wait for them."""
FIRST = ("slow", "reversals", "small_duty", "high_duty", "duty_levels")
"""Regions that a first verdict waits for: it says itself which effects the others would show."""
ENOUGH = "minutes"
"""Region that is enough, whatever else is missing."""
WITH_TEMPERATURE = ("warming",)


class Shown(NamedTuple):
    """How much of a region was driven: in its unit, how much is needed, and what to do for it."""

    region: str
    have: float
    need: float
    unit: str
    do: str

    @property
    def share(self) -> float:
        """Of what is needed, at most 1."""
        return min(self.have / self.need, 1.0)

    @property
    def done(self) -> bool:
        """Whether it is enough."""
        return self.have >= self.need


def coverage(channels: Mapping[str, Array], model: Model | None) -> list[Shown]:
    """How much a drive shows of each region, those that lack most first.

    channels (n,): `Heard.channels`; model: the reach of its rig counts where it says one, else that of the drive.
    """
    y = {name: each for name, each in channels.items() if name != "t"}
    course = course_of(bridged(Record("heard", channels["t"], y)))
    have = counts([course], reach_for(model, reach_of([course])))
    found = [
        Shown(name, have[name], cell.need, cell.unit, DO[name])
        for name, cell in CELLS.items()
        if name not in WITH_TEMPERATURE or "temperature" in y
    ]
    return sorted(found, key=lambda s: (s.done, s.region in LATER, s.share))


def carries(shown: list[Shown]) -> bool:
    """Whether the data carry a first verdict."""
    done = {s.region for s in shown if s.done}
    return ENOUGH in done or done.issuperset(FIRST)

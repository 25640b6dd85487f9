"""How soon an observer is sure again after its sensor was silent, and how wrong it then is (virtual time)."""

from __future__ import annotations

import math
import sys

from er_ros_common.injection import Kind
from er_studies.given_out import table as markdown

from er_common import topics
from er_damper_msgs.msg import DamperForce
from test.reliability.bus import NAMES, Bus

SILENCES = (0.06, 0.2, 0.5, 1.5)
"""Lengths [s]."""
AFTER = 10
"""Samples after the first OK in which the error is looked at."""


def run(drives: int) -> int:
    """Table over this many drives of each observer; 1 where an OK came late or too wrong, else 0."""
    late, rows = False, []
    for silence in SILENCES:
        row = [f"{silence:g}"]
        for deflection in (True, False):
            found = [
                once(name, seed, silence, deflection=deflection)
                for name in NAMES
                for seed in range(drives)
            ]
            took, wrong = ([each[i] for each in found] for i in (0, 1))
            late = late or not max(took) < math.inf
            row += [f"{min(took):.2f} to {max(took):.2f}", f"{max(wrong):.2f}"]
        rows.append(row)
    errors = "force wrong by at most, N"
    head = ("silence, s", "sure after, s", errors, "without the deflection: sure after, s", errors)
    sys.stdout.write(markdown(head, rows))
    return int(late)


def once(name: str, seed: int, silence: float, *, deflection: bool) -> tuple[float, float]:
    """Time from the first sample after a silence to OK [s], and the largest error soon after [N]."""
    topic = f"force/{name.removesuffix('_observer')}"
    bus = Bus((name, "skyhook_controller"), seed=seed, deflection=deflection)
    bus.run(2.0 + 0.13 * seed)
    gone = bus.log[topic][-1].t
    bus.inject(topics.ACCELERATION.name, Kind.OFF, duration=silence)
    bus.run(silence + 1.0)
    back = [each for each in bus.log[topic] if each.t >= gone + silence and each.message.valid]
    sure = [each for each in back if each.message.status == DamperForce.STATUS_OK]
    if not sure:
        return math.inf, math.inf
    truth = {each.message.seq: each.message.force for each in bus.log[topics.FORCE.name]}
    errors = [abs(each.message.force - truth[each.message.seq]) for each in sure[:AFTER]]
    return sure[0].t - back[0].t, max(errors)

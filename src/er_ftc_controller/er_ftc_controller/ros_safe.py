"""The safe duty of controllers without a mode for it: when it is due while inputs are silent, and its message."""

from __future__ import annotations

from er_common.common_parameters import Listening, silence
from er_ros_common.builders import Tick
from er_ros_common.core import When

from er_damper_msgs.msg import PwmDuty
from er_ros_common import builders

REPEAT = 50_000_000
"""How often the safe duty is asked for again [ns]."""


def due(p: Listening, heard: int, safe_at: int, when: When) -> bool:
    """Whether it is due; heard, safe_at: when a sample came last, when it was last asked for [ns, steady], 0: never."""
    since = silence(p, when.steady - heard)
    return bool(heard) and since > p.timeout and when.steady - safe_at > REPEAT


def message(duty: float, last: Tick, when: When) -> PwmDuty:
    """The duty from now on; in simulated time without a clock, from the last sample on."""
    tick = Tick(max(when.system or 0, last.stamp), last.seq)
    return builders.pwm_duty(tick, duty, source=PwmDuty.SOURCE_SAFE, status=PwmDuty.STATUS_LOST)

"""What the cores of all adapters do alike with messages that carry no number of ours."""

from __future__ import annotations

from typing import Any, TypeVar

from er_common.common_parameters import silence
from er_common.stamps import StampLimits, Verdict, check_stamp
from er_ros_common.core import When

S = TypeVar("S", bound=Any)


class Foreign:
    """p: patience and oldest sample; a state holds `stamps`, `number` of the messages and when one was `heard` [ns]."""

    p: Any
    limits: StampLimits

    def silent(self, state: Any, steady: int) -> bool:
        """Whether what is published stays away, at a time on the steady clock [ns]."""
        return bool(silence(self.p, steady - state.heard) > self.p.timeout)

    def counted(self, state: S, stamp: int, when: When) -> tuple[S, Verdict]:
        """One message more, with its stamp [ns] judged."""
        number, arrival = state.number + 1, when.system if self.p.max_age else None
        stamps, verdict = check_stamp(self.limits, state.stamps, stamp, number, arrival)
        return state._replace(stamps=stamps, number=number), verdict

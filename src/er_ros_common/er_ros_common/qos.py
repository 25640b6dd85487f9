"""Quality of service of every kind of topic.

Publishers of measurements are reliable and subscribers best effort (REP-2003): whoever needs every
sample can ask for it, and nobody is slowed down by who does not. No deadline and no lifespan:
asking for one cuts the connection to bags and to publishers that offer none.

A reliable writer keeps what a reader has not acknowledged, at most its depth: that is how long a recorder may be held
up. It costs nothing while readers keep pace, provided that they are asked soon for what they lack: `dds.py`.
"""

from __future__ import annotations

from typing import Final

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy


def _profile(depth: int, *, reliable: bool, latched: bool = False) -> QoSProfile:
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


KEPT: Final = 2000
"""Messages that a publisher keeps for a reader that lags behind: 10 s at 200 Hz."""
#: measurements and estimates at 200 Hz, publisher
SENSOR_PUBLISHER: Final = _profile(KEPT, reliable=True)
#: measurements and estimates at 200 Hz, subscriber: the newest few
SENSOR_SUBSCRIBER: Final = _profile(5, reliable=False)
#: measurements, subscriber that follows a state: every sample counts, more than a second of them waits
FOLLOWER: Final = _profile(250, reliable=False)
#: duty asked for, publisher
COMMAND_PUBLISHER: Final = _profile(KEPT, reliable=True)
#: duty asked for, subscriber: every answer arrives also where two samples came at once; whoever applies it judges
#: order and age by the sample that it answers, so that one from a queue does no harm
COMMAND: Final = _profile(10, reliable=True)
#: health of a node and what it was loaded with, both ends: late joiners get the last one
STATUS: Final = _profile(1, reliable=True, latched=True)
#: /diagnostics and /clock publishers, as in the rest of ROS 2
DIAGNOSTICS: Final = _profile(10, reliable=True)
#: a recorder: every sample, with 25 s in hand at 200 Hz of a stalled disk
RECORDER: Final = _profile(5000, reliable=True)

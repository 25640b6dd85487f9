"""Quality of service of every kind of topic, as plain numbers; `er_ros_common.qos` makes ROS's profiles of them.

Publishers of measurements are reliable and subscribers best effort (REP-2003): whoever needs every
sample can ask for it, and nobody is slowed down by who does not. No deadline and no lifespan:
asking for one cuts the connection to bags and to publishers that offer none.

A reliable writer keeps what a reader has not acknowledged, at most its depth: that is how long a recorder may be held
up. It costs nothing while readers keep pace, provided that they are asked soon for what they lack:
`er_ros_common/dds.py`.
"""

from __future__ import annotations

from typing import Final, NamedTuple


class Quality(NamedTuple):
    """Of one end: messages kept; whether every one is delivered; whether late joiners get the last ones."""

    depth: int
    reliable: bool
    latched: bool = False


class Ends(NamedTuple):
    """Of both ends of a topic."""

    publisher: Quality
    subscriber: Quality


KEPT: Final = 2000
"""Messages that a publisher keeps for a reader that lags behind: 10 s at 200 Hz."""
FOLLOWER: Final = Quality(250, reliable=False)
"""Measurements, subscriber that follows a state: every sample counts, more than a second of them waits."""
RECORDER: Final = Quality(5000, reliable=True)
"""A recorder: every sample, with 25 s in hand at 200 Hz of a stalled disk."""

SENSOR: Final = Ends(Quality(KEPT, reliable=True), Quality(5, reliable=False))
"""Measurements and estimates at 200 Hz; the subscriber takes the newest few."""
COMMAND: Final = Ends(Quality(KEPT, reliable=True), Quality(10, reliable=True))
"""Duty asked for. Every answer arrives also where two samples came at once; whoever applies it judges order and age by
the sample that it answers, so that one from a queue does no harm."""
STATUS: Final = Ends(*(Quality(1, reliable=True, latched=True),) * 2)
"""Health of a node and what it was loaded with: late joiners get the last one."""
DIAGNOSTICS: Final = Ends(*(Quality(10, reliable=True),) * 2)
"""/diagnostics, as in the rest of ROS 2."""
CLOCK: Final = Ends(DIAGNOSTICS.publisher, SENSOR.subscriber)
"""/clock; whoever listens wants the newest time alone."""

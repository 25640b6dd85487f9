"""The nlpv_gridding observer node; the estimate is `er_observers.observers.nlpv_gridding`."""

from __future__ import annotations

import sys

from er_ros_common.spin import run

from er_observers.nodes.shell import node_of
from er_observers.observers.nlpv_gridding import NAME
from er_ros_common import topics

TEXT = "Damper force from two accelerometers: NLPV observer with gains on a grid of duties."
NODE = node_of(NAME, topics.FORCE_GRIDDING, TEXT)


def main() -> None:
    """Entry point of the executable."""
    sys.exit(run(NODE.make, NODE.card))


if __name__ == "__main__":
    main()

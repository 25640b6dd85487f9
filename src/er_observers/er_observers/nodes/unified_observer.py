"""The unified observer node; the estimate is `er_observers.observers.unified`."""

from __future__ import annotations

import sys

from er_ros_common.spin import run

from er_observers.nodes.shell import node_of
from er_observers.observers.unified import NAME
from er_ros_common import topics

TEXT = "Damper force from two accelerometers: unified H-infinity observer, the road decoupled."
NODE = node_of(NAME, topics.FORCE_UNIFIED, TEXT)


def main() -> None:
    """Entry point of the executable."""
    sys.exit(run(NODE.make, NODE.card))


if __name__ == "__main__":
    main()

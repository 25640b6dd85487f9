"""The nlpv_gridding observer node; the estimate is `er_observers.observers.nlpv_gridding`."""

from __future__ import annotations

import sys

from er_observers.nodes.shell import serve
from er_observers.observers.nlpv_gridding import NAME
from er_ros_common import topics

TEXT = "Damper force from two accelerometers: NLPV observer with gains on a grid of duties."


def main() -> None:
    """Entry point of the executable."""
    sys.exit(serve(NAME, topics.FORCE_GRIDDING, TEXT))


if __name__ == "__main__":
    main()

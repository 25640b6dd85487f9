"""The nlpv_polytopic observer node; the estimate is `er_observers.observers.nlpv_polytopic`."""

from __future__ import annotations

import sys

from er_observers.nodes.shell import serve
from er_observers.observers.nlpv_polytopic import NAME
from er_ros_common import topics

TEXT = "Damper force from two accelerometers: NLPV observer with constant Lyapunov function."


def main() -> None:
    """Entry point of the executable."""
    sys.exit(serve(NAME, topics.FORCE_POLYTOPIC, TEXT))


if __name__ == "__main__":
    main()

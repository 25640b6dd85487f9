"""The NLPV polytopic observer node; its gains are those of the theorem `er_observers.synthesis.nlpv_polytopic`."""

from __future__ import annotations

import sys

from er_ros_common.spin import run

from er_observers.nodes.shell import node_of

TEXT = "Damper force from two accelerometers: NLPV observer with constant Lyapunov function."
NODE = node_of("nlpv_polytopic", TEXT)


def main() -> None:
    """Entry point of the executable."""
    sys.exit(run(NODE.make, NODE.card))


if __name__ == "__main__":
    main()

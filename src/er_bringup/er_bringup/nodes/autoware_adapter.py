"""Autoware's velocity report for the body of a car; the message package is that of the vehicle."""

from __future__ import annotations

import sys

from er_ros_common.spin import run

from er_bringup.nodes.adapter import executable
from er_bringup.programs import AUTOWARE_ADAPTER
from er_bringup.ros_autoware import REPORT, AutowareCore, AutowareParameters
from er_common import topics

NODE = executable(AUTOWARE_ADAPTER, AutowareParameters, AutowareCore, (REPORT,), topics.BODY_LOAD)


def main() -> None:
    """Entry point of the executable; `ModuleNotFoundError` where the message package is not there."""
    if not {"-h", "--help"} & {*sys.argv}:
        _ = REPORT.type
    sys.exit(run(NODE.make, NODE.card))


if __name__ == "__main__":
    main()

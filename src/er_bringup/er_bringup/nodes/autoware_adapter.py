"""Autoware's velocity report for the body of a car; the message package is that of the vehicle."""

from __future__ import annotations

from er_bringup.nodes.adapter import entry, executable
from er_bringup.programs import AUTOWARE_ADAPTER
from er_bringup.ros_autoware import REPORT, AutowareCore, AutowareParameters
from er_common import topics

NODE = executable(AUTOWARE_ADAPTER, AutowareParameters, AutowareCore, (REPORT,), topics.BODY_LOAD)
main = entry(NODE)

if __name__ == "__main__":
    main()

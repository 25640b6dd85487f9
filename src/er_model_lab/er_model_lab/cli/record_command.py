"""``er record OUT``: the recorder node with plain options."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from er_models.one_line import OneLine
from er_records.recording.bag_writer import STORAGES
from er_ros_common.arguments import Value, ros_arguments


def parser() -> OneLine:
    """The options of the command."""
    p = OneLine(
        prog="er record",
        description="Record topics into a new rosbag2 folder until Ctrl-C.",
        allow_abbrev=False,
    )
    p.add_argument("out", metavar="OUT", help="folder to be made for the recording")
    p.add_argument("--storage", choices=tuple(STORAGES), default="mcap", help="format (mcap)")
    p.add_argument("--topics", nargs="+", default=[], metavar="TOPIC", help="only these topics")
    p.add_argument("--all", action="store_true", help="every topic of the graph")
    p.add_argument("--duration", type=float, default=0.0, metavar="S", help="stop after S seconds")
    p.add_argument("--namespace", default="", metavar="NS", help="namespace of the corner")
    return p


def node_arguments(argv: Sequence[str]) -> list[str]:
    """Arguments of the recorder node; exits with status 2 and one line on bad usage."""
    o = parser().parse_args(argv)
    parameters: dict[str, Value] = {"out": o.out, "storage": o.storage, "all": o.all}
    parameters["duration"] = o.duration
    if o.topics:
        parameters["topics"] = o.topics
    return ros_arguments(parameters=parameters, namespace=o.namespace)


def main() -> None:
    """Entry point of the command."""
    arguments = node_arguments(sys.argv[1:])
    # only now: help and bad usage need no ROS
    from er_model_lab.nodes.recorder import record

    sys.exit(record(arguments))


if __name__ == "__main__":
    main()

"""``er inject``: spoils one channel of a running plant or bridge, to see what the rest does with it.

    er inject sensors/acceleration off --seconds 1
    er inject sensors/acceleration.sprung bias 2.0
    er inject pwm/command delayed 0.03
    er inject sensors/acceleration ok

The node must have been started with enable_fault_injection:=true. Exit status 0 when it is in force, 1 when it was
refused or nobody answered, 2 for bad usage.
"""

from __future__ import annotations

import argparse
import sys

from er_models.one_line import OneLine, end_with
from er_ros_common.fault_port import SERVICE
from er_ros_common.injection import Kind

from er_bringup.doctor import namespace
from er_bringup.ros_ask import asked
from er_damper_msgs.srv import InjectFault


def parser() -> OneLine:
    """Options of the command."""
    p = OneLine(prog="er inject", description=(__doc__ or "").split("\n")[0], allow_abbrev=False)
    p.add_argument("unit", help="topic, or TOPIC.FIELD: sensors/acceleration.sprung")
    p.add_argument("kind", choices=[kind.name.lower() for kind in Kind])
    p.add_argument(
        "value",
        nargs="?",
        type=float,
        default=0.0,
        help="size: bias in the unit of the field, rate in Hz, delay in s, or probability",
    )
    p.add_argument(
        "--seconds", type=float, default=0.0, help="how long [s]; 0: until it is ended with ok"
    )
    p.add_argument("--node", type=namespace, default="plant", help="node to ask (plant)")
    p.add_argument(
        "--namespace", type=namespace, default="", metavar="NS", help="namespace of the corner"
    )
    return p


def ask(name: str, request: InjectFault.Request) -> tuple[bool, str]:
    """Whether a node, by full name, does it, and what it says."""
    answer = asked(InjectFault, SERVICE.replace("~", name), request)
    if answer is None:
        return False, f"{name} does not answer: is it running?"
    return bool(answer.accepted), str(answer.reason)


def main() -> None:
    """Entry point of the command."""
    options = parser().parse_args()
    end_with("er inject", lambda: run(options))


def run(o: argparse.Namespace) -> int:
    """Ask as the options say; the exit status."""
    request = InjectFault.Request(unit=o.unit, value=o.value, duration=o.seconds)
    request.kind = int(Kind[o.kind.upper()])
    space = o.namespace.strip("/")
    accepted, reason = ask(f"/{space}/{o.node}" if space else f"/{o.node}", request)
    if accepted:
        print(reason)  # noqa: T201  (asked for)
    else:
        sys.stderr.write(f"er inject: {reason}\n")
    return 0 if accepted else 1


if __name__ == "__main__":
    main()

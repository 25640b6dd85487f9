"""Writes the files for recording, plotting and access control, for one namespace or all corners of a car.

./er exec python -m er_bringup.integration.write --out DIR [--namespace NS]
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from er_models.files import write_whole
from er_models.one_line import OneLine

from er_bringup.given import CAR
from er_bringup.integration import foxglove, plotjuggler, ros_recording, ros_sros2
from er_bringup.integration.names import BASE


def files(namespace: str = "") -> Mapping[str, str]:
    """Name of each file below the folder, and its text."""
    car = [f"{BASE}/{corner}" for corner in CAR]
    return {
        "recording/qos_overrides.yaml": ros_recording.overrides([namespace]),
        "recording/qos_overrides_car.yaml": ros_recording.overrides(car),
        "recording/mcap_writer.yaml": ros_recording.writer(),
        "layouts/plotjuggler.xml": plotjuggler.layout(namespace),
        "layouts/foxglove.json": foxglove.layout(namespace),
        "sros2/policy.xml": ros_sros2.policy([namespace]),
    }


def main() -> None:
    """Entry point of the command."""
    p = OneLine(prog="write", description=__doc__)
    p.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder to write into")
    p.add_argument("--namespace", default="", metavar="NS", help="namespace of the corner")
    options = p.parse_args()
    for name, text in files(options.namespace).items():
        path = options.out / name
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, text)


if __name__ == "__main__":
    main()

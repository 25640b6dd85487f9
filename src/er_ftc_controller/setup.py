"""What colcon needs beside pyproject.toml: a place in the index of ament, and the nodes' programs."""

import re
import sys
from pathlib import Path
from xml.etree import ElementTree

from setuptools import setup

PACKAGE = "er_ftc_controller"
WHEEL = {"bdist_wheel", "dist_info"} & {*sys.argv}
"""Whether pip makes a wheel, which has no programs that need ROS."""


def programs() -> list[str]:
    """Console scripts of `programs.py`, read as text: what it imports is not there while the package is built."""
    rows = Path(PACKAGE, "programs.py").read_text(encoding="utf-8")
    names = re.findall(r'\bProgram\(\s*"(\w+)"', rows)
    return [f"{name} = {PACKAGE}.executables:{name}" for name in names]


setup(
    version=ElementTree.parse("package.xml").findtext("version"),
    license="Apache-2.0",
    python_requires=">=3.10",
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml", "pyproject.toml", "README.md"]),
    ],
    entry_points={"console_scripts": [] if WHEEL else programs()},
    zip_safe=False,
)

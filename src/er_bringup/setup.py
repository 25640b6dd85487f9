"""Packaging of er_bringup: for colcon."""

import re
from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

PACKAGE = "er_bringup"


def programs() -> list[str]:
    """Console scripts of `programs.py`, read as text: what it imports is not there while the package is built."""
    rows = Path(PACKAGE, "programs.py").read_text(encoding="utf-8")
    names = re.findall(r'\bProgram\(\s*"(\w+)"', rows)
    return [f"{name} = {PACKAGE}.executables:{name}" for name in names]


def tree(folder: str) -> list[tuple[str, list[str]]]:
    """Files of a folder and of the folders below it, each with where it is installed."""
    places: dict[str, list[str]] = {}
    for path in sorted(Path(folder).rglob("*")):
        if path.is_file():
            places.setdefault(f"share/{PACKAGE}/{path.parent}", []).append(str(path))
    return list(places.items())


setup(
    name=PACKAGE,
    version=ElementTree.parse("package.xml").findtext("version"),
    description="Starts the whole graph: launch files, configuration, demonstration, graph check.",
    license="Apache-2.0",
    python_requires=">=3.10",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={PACKAGE: ["py.typed", "**/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        *tree("launch"),
        *tree("config"),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest", "pytest-timeout"]},
    zip_safe=False,
    entry_points={"console_scripts": programs()},
)

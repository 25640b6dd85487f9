"""Packaging of er_bringup: for colcon."""

from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

PACKAGE = "er_bringup"


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
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "composed = er_bringup.executables:composed",
            "ros2_control_joint = er_bringup.executables:ros2_control_joint",
        ]
    },
)

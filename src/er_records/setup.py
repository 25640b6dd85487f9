"""What colcon needs beside pyproject.toml: a place in the index of ament."""

from xml.etree import ElementTree

from setuptools import setup

PACKAGE = "er_records"

setup(
    version=ElementTree.parse("package.xml").findtext("version"),
    license="Apache-2.0",
    python_requires=">=3.10",
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml", "pyproject.toml", "README.md"]),
    ],
    zip_safe=False,
)

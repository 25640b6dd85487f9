"""Packaging of er_ros_common: for colcon."""

from xml.etree import ElementTree

from setuptools import find_packages, setup

PACKAGE = "er_ros_common"

setup(
    name=PACKAGE,
    version=ElementTree.parse("package.xml").findtext("version"),
    description="What every node shares: spinning, quality of service, builders, clocks, health.",
    license="Apache-2.0",
    python_requires=">=3.10",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={PACKAGE: ["py.typed", "dds.xml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest", "pytest-timeout"]},
    zip_safe=False,
)

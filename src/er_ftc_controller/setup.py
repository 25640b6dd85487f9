"""Packaging of er_ftc_controller: for colcon and for pip."""

from setuptools import find_packages, setup

PACKAGE = "er_ftc_controller"

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Controllers of the semi-active damper: Skyhook, fault-tolerant LPV.",
    license="Apache-2.0",
    maintainer="ER damper developers",
    maintainer_email="maintainers@er-damper.invalid",
    python_requires=">=3.10",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={PACKAGE: ["py.typed", "**/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "ftc_controller = er_ftc_controller.executables:ftc_controller",
            "skyhook_controller = er_ftc_controller.executables:skyhook_controller",
        ],
    },
)

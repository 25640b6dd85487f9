"""Packaging of er_plant_sim: for colcon and for pip."""

from setuptools import find_packages, setup

PACKAGE = "er_plant_sim"

setup(
    name=PACKAGE,
    version="0.1.0",
    description="A quarter car with a semi-active damper as a ROS 2 node.",
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
            "plant = er_plant_sim.executables:plant",
            "hardware_bridge = er_plant_sim.executables:hardware_bridge",
            "device_emulator = er_plant_sim.executables:device_emulator",
        ],
    },
)

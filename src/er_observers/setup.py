"""Packaging of er_observers: for colcon and for pip."""

from setuptools import find_packages, setup

PACKAGE = "er_observers"

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Observers of the damper force, and the offline synthesis of their gains.",
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
            "unified_observer = er_observers.executables:unified_observer",
            "nlpv_polytopic_observer = er_observers.executables:nlpv_polytopic_observer",
            "nlpv_gridding_observer = er_observers.executables:nlpv_gridding_observer",
            "fault_estimator = er_observers.executables:fault_estimator",
        ],
    },
)

"""Packaging of er_models: for colcon and for pip."""

from setuptools import find_packages, setup

PACKAGE = "er_models"

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Pure models of semi-active dampers and quarter cars, composed of effects.",
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
    install_requires=["setuptools", "numpy", "scipy", "numba", "PyYAML"],
    zip_safe=False,
)

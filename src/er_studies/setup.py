"""Packaging of er_studies: for colcon and for pip."""

from setuptools import find_packages, setup

PACKAGE = "er_studies"

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Makes the thesis's tables again, measures speed, compares with rivals, imports measured data sets.",
    license="Apache-2.0",
    maintainer="ER damper developers",
    maintainer_email="maintainers@er-damper.invalid",
    python_requires=">=3.10",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={PACKAGE: ["py.typed", "**/*.c"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    zip_safe=False,
)

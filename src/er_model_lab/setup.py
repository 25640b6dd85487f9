"""Packaging of er_model_lab: for colcon and for pip."""

from setuptools import find_packages, setup

PACKAGE = "er_model_lab"

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Compares a damper model with measurements and names the missing effect.",
    license="Apache-2.0",
    maintainer="ER damper developers",
    maintainer_email="maintainers@er-damper.invalid",
    python_requires=">=3.10",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={
        PACKAGE: [
            "py.typed",
            "**/*.yaml",
            "**/*.json",
            "**/*.j2",
            "**/*.html",
            "**/*.css",
            "**/*.js",
        ]
    },
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "recorder = er_model_lab.executables:recorder",
            "er-lab = er_model_lab.cli.app:main",
        ],
    },
)

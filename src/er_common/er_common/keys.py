"""Python modules that our packages import, and rosdep's keys for them (rosdistro's rosdep/python.yaml). No ROS here."""

from __future__ import annotations

from typing import Final

KEYS: Final = {
    "PIL": "python3-pil",
    "autoware_vehicle_msgs": "autoware_vehicle_msgs",
    "control_msgs": "control_msgs",
    "cvxpy": "python3-cvxpy-pip",
    "h5py": "python3-h5py",
    "hypothesis": "python3-hypothesis",
    "jinja2": "python3-jinja2",
    "matplotlib": "python3-matplotlib",
    "numba": "python3-numba",
    "numpy": "python3-numpy",
    "pandas": "python3-pandas",
    "psutil": "python3-psutil",
    "pytest": "python3-pytest",
    "rich": "python3-rich",
    "rosbags": "python3-rosbags-pip",
    "scipy": "python3-scipy",
    "serial": "python3-serial",
    "sklearn": "python3-sklearn",
    "typer": "python3-typer",
    "yaml": "python3-yaml",
}
PIP: Final = (
    "asammdf",
    "dask",
    "distributed",
    "fsspec",
    "nicegui",
    "nptdms",
    "playwright",
    "pyarrow",
    "python_calamine",
)
"""Modules for which rosdep has no key."""


def lacking(program: str, error: ModuleNotFoundError) -> str:
    """One line for a module that is not there, with what installs it; empty where it is none of these."""
    module = str(error.name).partition(".")[0]
    if module in PIP:
        return f"{program}: needs the Python package {module}, for which rosdep has no key: pip install {module}"
    if module not in KEYS:
        return ""
    return (
        f"{program}: needs the Python module {module}: install rosdep's key {KEYS[module]} "
        "(rosdep install --from-paths src --ignore-src)"
    )

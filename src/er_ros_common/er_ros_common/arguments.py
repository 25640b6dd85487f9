"""Command lines of nodes: parameters in a form that ROS cannot take for another type."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

Value = bool | int | float | str | Sequence[str] | Sequence[int] | Sequence[float]


def ros_arguments(
    *,
    parameters: Mapping[str, Value] | None = None,
    files: Sequence[str] = (),
    name: str = "",
    namespace: str = "",
    remaps: Mapping[str, str] | None = None,
    log_level: str = "",
    enclave: str = "",
) -> list[str]:
    """What follows the executable; nothing when there is nothing to say.

    Parameter files come first, so that single parameters win over them.
    """
    found: list[str] = []
    if namespace:
        found += ["-r", f"__ns:=/{namespace.strip('/')}"]
    if name:
        found += ["-r", f"__node:={name}"]
    for old, new in (remaps or {}).items():
        found += ["-r", f"{old}:={new}"]
    if enclave:
        found += ["--enclave", enclave]
    if log_level:
        found += ["--log-level", log_level]
    for file in files:
        found += ["--params-file", file]
    for key, value in (parameters or {}).items():
        found += ["-p", f"{key}:={written(value)}"]
    return ["--ros-args", *found] if found else []


def written(value: Value) -> str:
    """A value as ROS reads it: a text stays a text, a whole float stays a float."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        # 1e-05 is a text for the parser of ROS; 1.0e-05 is a number
        text = repr(value)
        mantissa, e, exponent = text.partition("e")
        return text if not e else f"{mantissa if '.' in mantissa else mantissa + '.0'}e{exponent}"
    if isinstance(value, str):
        return "'" + value.replace("'", "''") + "'"
    return f"[{', '.join(written(entry) for entry in value)}]"

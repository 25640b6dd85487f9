"""Definitions of message types, from installed packages: a bag carries them along."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from ament_index_python.packages import PackageNotFoundError, get_package_share_directory
from er_models.errors import ErError
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore


@lru_cache(maxsize=1)
def _store() -> Typestore:
    """Types of ROS 2 Jazzy, to which others are added as they are met."""
    return get_typestore(Stores.ROS2_JAZZY)


@lru_cache(maxsize=256)
def full_definition(type_name: str) -> tuple[str, str]:
    """Text of a type (`package/msg/Name`) with all it is made of, comments and all; its hash.

    The form is that of ros2msg: the type, then each part after a line of equal signs and its name.

    Raises:
        ErError: The package of a type is not installed, or has no definition of it.
    """
    store, texts = _store(), _texts(type_name, {})
    for name, text in texts.items():
        if name not in store.fielddefs:
            store.register({name: get_types_from_msg(text, name)[name]})
    first, *parts = texts.items()
    rest = [f"{'=' * 80}\nMSG: {name.replace('/msg/', '/')}\n{text}" for name, text in parts]
    return "\n".join([first[1], *rest]), store.hash_rihs01(type_name)


def _texts(type_name: str, found: dict[str, str]) -> dict[str, str]:
    """Texts of a type and of all it is made of, by name; the type itself comes first."""
    if type_name not in found:
        found[type_name] = _definition(type_name)
        parsed = get_types_from_msg(found[type_name], type_name)
        for part in sorted(_used(parsed[type_name][1])):
            _texts(part, found)
    return found


def _used(fields: object) -> set[str]:
    """Names of the message types among field definitions, however nested."""
    if isinstance(fields, str):
        return {fields} if fields.count("/") == 2 else set()
    if isinstance(fields, (list, tuple)):
        return set().union(*(_used(part) for part in fields)) if fields else set()
    return set()


def _definition(type_name: str) -> str:
    package, _, name = type_name.partition("/msg/")
    try:
        folder = Path(get_package_share_directory(package))
        return (folder / "msg" / f"{name}.msg").read_text(encoding="utf-8")
    except (PackageNotFoundError, ValueError):
        raise ErError(f"type {type_name}: package {package} is not installed") from None
    except OSError:
        raise ErError(f"type {type_name}: {package} has no definition of it") from None

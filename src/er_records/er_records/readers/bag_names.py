"""Usual names of topics that were recorded under others: as the recorder noted them, or found by their types."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from er_models.errors import InputError

from er_records.readers.bag_files import METADATA, metadata

PACKAGE = "er_damper_msgs/msg/"
ALONE = {
    f"{PACKAGE}SuspensionDeflection": "sensors/deflection",
    f"{PACKAGE}SuspensionAcceleration": "sensors/acceleration",
    f"{PACKAGE}RoadDisplacement": "sensors/road",
}
"""Types that a corner has one topic of."""
AMONG_OTHERS = {f"{PACKAGE}DamperForce": "sensors/force", f"{PACKAGE}PwmDuty": "pwm/applied"}
"""Types that other topics of a corner have too: estimates, the duty asked for."""
OURS: dict[str, type] = {"parameters": dict, "models": str, "names": str}
"""What our recorder notes by name of node or topic, and of which kind each entry is."""
_USUAL = re.compile(
    r"^(?P<ns>.*?)/(?:sensors/(?:deflection|acceleration|force|road)|pwm/(?:applied|command)"
    r"|fault/estimate|model/(?:force|residual)|force/\w+)$"
)


def custom_data(path: Path) -> dict[str, Any]:
    """What our recorder noted about a recording (folder, or a file of one); empty where another one recorded.

    Raises:
        InputError: Nobody could have noted that.
    """
    folder = path if path.is_dir() else path.parent
    data, found = metadata(folder).get("custom_data") or {}, {}
    if not isinstance(data, dict):
        raise InputError(folder / METADATA, "custom_data", "texts by name", repr(data)[:60])
    for key, text in data.items():
        if str(text).startswith(("{", "[")):
            try:
                found[str(key)] = json.loads(text)
            except ValueError:
                continue
    for key, kind in OURS.items():
        noted = found.get(key, {})
        if not (isinstance(noted, dict) and all(isinstance(v, kind) for v in noted.values())):
            entry = "parameters by name" if kind is dict else "a text"
            expected = f"an object with {entry} for each name"
            where = f"custom_data: {key}"
            raise InputError(folder / METADATA, where, expected, json.dumps(noted)[:60])
    return found


def usual_names(path: Path, kinds: Mapping[str, str]) -> tuple[dict[str, str], list[str]]:
    """Usual names by recorded ones, of topics that have others, and a sentence for each that was guessed.

    A type tells the topic where the recording is of one corner, and that corner has no topic of the usual name.

    Args:
        path: of the recording.
        kinds: type of each topic by its recorded name.
    """
    noted = custom_data(path).get("names", {})
    found = {other: usual for usual, other in noted.items() if other in kinds}
    ours = {topic for topic, kind in kinds.items() if kind.startswith(PACKAGE)}
    named = {found.get(topic, topic) for topic in ours}
    spaces = {match["ns"] for match in map(_USUAL.match, named) if match}
    said: list[str] = []
    if len(spaces) > 1:
        return found, said
    space = next(iter(spaces), "")
    for kind, key in (ALONE | AMONG_OTHERS).items():
        same = [topic for topic in ours if kinds[topic] == kind]
        strange = [topic for topic in same if topic not in found and not _USUAL.match(topic)]
        certain = len(strange) == 1 and (kind in ALONE or len(same) == 1)
        if certain and f"{space}/{key}" not in named:
            found[strange[0]] = f"{space}/{key}"
            said.append(f"{strange[0]} is read as {key}: the only one of type {kind}")
    return found, said


def hint(kinds: Mapping[str, str]) -> str:
    """What to do where no topic has its usual name and types do not tell; empty where none is of ours."""
    of_motion = tuple(ALONE)[:2]
    found = sorted(topic for topic, kind in kinds.items() if kind in of_motion)
    if not found:
        return ""
    return (
        f" (of its kind are {', '.join(found)}, under names of their own: "
        "play one corner with `ros2 bag play --remap OWN:=USUAL` and record it anew)"
    )

"""Files of whole cars: a body, and a vehicle model for each corner.

    schema: er_car 1
    name: inove_car
    body: {mass: 9.08, roll_inertia: 0.13, pitch_inertia: 0.57, to_front: 0.24, ...}
    corners: {front: inove_quarter_car.yaml, rear: inove_quarter_car.yaml, rear_left: leaking.yaml}

`front` and `rear` serve both sides of an axle; a corner of its own name goes before them.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from er_models.car.body import CORNERS, Car
from er_models.catalogue import CATALOGUE, Catalogue
from er_models.errors import InputError
from er_models.files import load_model
from er_models.model import Model
from er_models.shipped import file_of
from er_models.spec import REQUIRED, Number, Setting, Text, settings
from er_models.yaml_file import read_yaml

SCHEMA = "er_car 1"
_TOP: tuple[Setting, ...] = (
    Text("schema", REQUIRED, f"'{SCHEMA}'", (SCHEMA,)),
    Text("name", "", "name"),
    Text("source", "", "where the numbers come from"),
)
BODY = (
    Number("mass", "kg", REQUIRED, 1e-2, 1e5, "mass of the body"),
    Number("roll_inertia", "kg m2", REQUIRED, 1e-5, 1e6, "about the axis forward, through the centre"),
    Number("pitch_inertia", "kg m2", REQUIRED, 1e-5, 1e6, "about the axis to the left"),
    Number("to_front", "m", REQUIRED, 1e-2, 20.0, "from the centre forward to the front axle"),
    Number("to_rear", "m", REQUIRED, 1e-2, 20.0, "from the centre back to the rear axle"),
    Number("front_track", "m", REQUIRED, 1e-2, 5.0, "between the front wheels"),
    Number("rear_track", "m", REQUIRED, 1e-2, 5.0, "between the rear wheels"),
    Number("front_bar", "N/m", 0.0, 0.0, 1e6, "anti-roll bar: force at a wheel per difference of deflections"),
    Number("rear_bar", "N/m", 0.0, 0.0, 1e6, "the same behind"),
    Number("height", "m", 0.0, 0.0, 5.0, "of the centre above the road"),
    Number("seat_forward", "m", 0.0, -20.0, 20.0, "place of the seat, forward of the centre"),
    Number("seat_left", "m", 0.0, -5.0, 5.0, "the same to the left"),
)  # fmt: skip
_CORNERS = (*CORNERS, "front", "rear")


def load_car(path: str | Path, catalogue: Catalogue = CATALOGUE) -> Car:
    """Read a car file, or the shipped car of a name (`inove_car`); catalogue: with own effects that corners need.

    Raises `InputError` naming file, key, expected and found: as `load_model`, a corner without a model, a model of
    another kind, or one whose sprung mass is changed by an effect (the body's counts).
    """
    path = file_of(path, "cars")
    text = read_yaml(path, "a car file")
    if not isinstance(text, Mapping):
        raise InputError(path, "", "a mapping of names to values", type(text).__name__)
    top = settings(_TOP, text, path, also=("body", "corners"))
    body = settings(BODY, _part(path, text, "body"), path, "body", also=())
    seat = (body.pop("seat_forward"), body.pop("seat_left"))
    corners = tuple(
        _corner(path, _part(path, text, "corners"), name, catalogue) for name in CORNERS
    )
    return Car(
        top["name"] or path.stem, **body, seat=seat, corners=corners, source=top["source"]
    )  # fmt: skip


def _part(path: Path, text: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    found = text.get(key)
    if not isinstance(found, Mapping):
        raise InputError(path, key, "a mapping of names to values", type(found).__name__)
    return found


def _corner(path: Path, given: Mapping[str, Any], name: str, catalogue: Catalogue) -> Model:
    """The model of a corner."""
    for key in given:
        if key not in _CORNERS:
            raise InputError(
                path, f"corners.{key}", f"one of {', '.join(_CORNERS)}", "an unknown key"
            )
    key = name if name in given else name.split("_")[0]
    if not isinstance(given.get(key), str):
        raise InputError(path, f"corners.{key}", "a vehicle model file", repr(given.get(key)))
    near = path.parent / given[key]
    model = load_model(near if near.exists() else given[key], catalogue)
    if not model.is_vehicle:
        raise InputError(
            path, f"corners.{key}", "a vehicle model with quarter_car", "a damper only"
        )
    if "sprung_mass_error" in model.effects:
        expected = "no sprung_mass_error: the body's mass counts"
        raise InputError(path, f"corners.{key}", expected, "one")
    return model

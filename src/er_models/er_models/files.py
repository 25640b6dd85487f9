"""Model files: YAML with units, deviations and history; unknown keys and values out of bounds are refused."""

from __future__ import annotations

import json
import math
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from er_models.catalogue import CATALOGUE, Catalogue, Origin
from er_models.errors import InputError, UnknownName
from er_models.measured import read_terms
from er_models.model import Model
from er_models.scales import Scales
from er_models.shipped import MODELS, file_of
from er_models.yaml_file import read_yaml

SCHEMA = "er_model 1"
_KEYS = (
    "schema", "name", "source", "envelope", "rig", "damper", "effects_from", "effects", "measured_terms", "history"
)  # fmt: skip
_ENVELOPE = ("force", "deflection", "velocity", "duty")
_VALUE_KEYS = ("value", "sd", "unit")


def load_model(path: str | Path, catalogue: Catalogue = CATALOGUE) -> Model:
    """Read a damper or vehicle model file, or the shipped model of a name (`inove_guo`).

    catalogue: with the user's own effects that the file needs (`er_models.own`).

    Raises `InputError` naming file, key, expected and found: missing file, unknown name, broken YAML, unknown key,
    wrong unit, value out of bounds or not finite, an own effect that was not given or is another.
    """
    path = file_of(path, *MODELS)
    text = _mapping(path, "", read_yaml(path, "a model file"))
    for key in text:
        if key not in _KEYS:
            raise InputError(path, str(key), f"one of {', '.join(_KEYS)}", "an unknown key")
    if text.get("schema") != SCHEMA:
        raise InputError(path, "schema", f"'{SCHEMA}'", repr(text.get("schema")))
    _check_origins(path, text.get("effects_from", []), catalogue)
    base = _damper(path, text["damper"], catalogue) if "damper" in text else None
    scales = _scales(path, text) if "envelope" in text or base is None else base.scales
    effects, deviations = _effects(
        path, _mapping(path, "effects", text.get("effects", {})), scales, catalogue
    )
    return Model(
        name=str(text.get("name", path.stem)),
        effects={**(base.effects if base else {}), **effects},
        scales=scales,
        source=str(text.get("source", "")),
        deviations={**(base.deviations if base else {}), **deviations},
        history=_history(path, text.get("history")) or (base.history if base else ()),
        rig=_numbers(path, "rig", text.get("rig") or (base.rig if base else {})),
        catalogue=catalogue,
        terms=read_terms(path, text.get("measured_terms", {})) or (base.terms if base else ()),
        file=str(path),
    )


def _history(path: Path, found: Any) -> tuple[Mapping[str, Any], ...]:
    """Entries of the history, one mapping each."""
    if found is None:
        return ()
    if not isinstance(found, list):
        raise InputError(path, "history", "a list of mappings", type(found).__name__)
    return tuple(_mapping(path, f"history.{k}", entry) for k, entry in enumerate(found))


def save_model(model: Model, path: str | Path) -> None:
    """Write a model file that `load_model` reads: values with units and deviations [SI], envelope, rig and history.

    It is written whole or not at all. Raises `InputError` where it cannot be.
    """
    effects: dict[str, Any] = {}
    for name, values in model.effects.items():
        effects[name] = {}
        for q in model.catalogue[name].parameters:
            entry: dict[str, Any] = {"value": float(values[q.name]), "unit": q.unit}
            sd = model.deviations.get(name, {}).get(q.name)
            if sd is not None and math.isfinite(sd):
                entry["sd"] = float(sd)
            effects[name][q.name] = entry
    s = model.scales
    document = {
        "schema": SCHEMA,
        "name": model.name,
        "source": model.source,
        "envelope": {k: float(getattr(s, k)) for k in _ENVELOPE},
        "rig": dict(model.rig),
        **_origins(model),
        "effects": effects,
        **({"measured_terms": {t.name: t.as_json() for t in model.terms}} if model.terms else {}),
        "history": [dict(h) for h in model.history],
    }
    text = yaml.safe_dump(
        document, sort_keys=False, allow_unicode=True, width=110, default_flow_style=None
    )
    write_whole(Path(path), text)


def _origins(model: Model) -> dict[str, Any]:
    """The files of the user's own effects in use, by their content."""
    files: dict[Origin, list[str]] = {}
    for name in model.effects:
        if name in model.catalogue.origins:
            files.setdefault(model.catalogue.origins[name], []).append(name)
    entries = [{"file": o.file, "sha256": o.digest, "effects": e} for o, e in files.items()]
    return {"effects_from": entries} if entries else {}


def _check_origins(path: Path, found: Any, catalogue: Catalogue) -> None:
    """Refuse a model with own effects whose file was not given, or has other content."""
    entries = found if isinstance(found, list) else [found]
    for i, entry in enumerate(entries):
        where = f"effects_from[{i}]"
        entry = _mapping(path, where, entry)
        file, digest, names = (entry.get(key) for key in ("file", "sha256", "effects"))
        if not isinstance(names, list) or len(entry) != 3:
            raise InputError(path, where, "file, sha256 and effects", ", ".join(map(str, entry)))
        for name in names:
            given = catalogue.origins.get(name)
            if given is None:
                expected = (
                    f"the file {file} given as --effects-from (a node's effects_from), "
                    f"for its effect '{name}'"
                )
                raise InputError(path, where, expected, "no file with that effect")
            if given.digest != digest:
                expected = f"{file} with the content {str(digest)[:12]} (SHA-256)"
                raise InputError(path, where, expected, f"{given.file} with {given.digest[:12]}")


def write_json(path: Path | None, content: Any) -> None:
    """Write figures where a file is asked for, whole or not at all; arrays become lists.

    Raises:
        ValueError: A figure that JSON does not know.
    """
    if path is not None:
        text = json.dumps(content, indent=1, allow_nan=False, default=np.ndarray.tolist)
        write_whole(path, text + "\n")


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file so that a reader sees the old or the new one, never half; text is UTF-8."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    except OSError as error:
        raise InputError(
            path, "", "a folder that can be written to", error.strerror or error
        ) from error
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except OSError as error:
        os.unlink(temporary)
        raise InputError(
            path, "", "a file that can be written", error.strerror or error
        ) from error


def _damper(path: Path, found: Any, catalogue: Catalogue) -> Model:
    """The model of the damper file that a vehicle file names, relative to it."""
    other = path.parent / str(found)
    if other.resolve() == path.resolve():
        raise InputError(path, "damper", "another file", "the file itself")
    inner = _mapping(other, "", read_yaml(other, "a model file"))
    if "damper" in inner:
        raise InputError(other, "damper", "a damper file, which refers to no other", "one more")
    return load_model(other, catalogue)


def _mapping(path: Path, key: str, found: Any) -> Mapping[str, Any]:
    """A mapping, or one clear line."""
    if not isinstance(found, dict):
        raise InputError(path, key, "a mapping of names to values", type(found).__name__)
    return found


def _number(path: Path, key: str, found: Any) -> float:
    """A finite number (or infinity where written as .inf), or one clear line."""
    if isinstance(found, bool) or not isinstance(found, int | float) or math.isnan(found):
        raise InputError(path, key, "a number", repr(found))
    return float(found)


def _numbers(path: Path, key: str, found: Any) -> dict[str, float]:
    """A mapping of names to numbers."""
    return {str(k): _number(path, f"{key}.{k}", v) for k, v in _mapping(path, key, found).items()}


def _scales(path: Path, text: Mapping[str, Any]) -> Scales:
    """The envelope of use."""
    envelope = _numbers(path, "envelope", text.get("envelope"))
    for key in _ENVELOPE:
        if not envelope.get(key, 0.0) > 0.0 or not math.isfinite(envelope[key]):
            raise InputError(
                path, f"envelope.{key}", "a number above 0", envelope.get(key, "nothing")
            )
    for key in envelope:
        if key not in _ENVELOPE:
            raise InputError(
                path, f"envelope.{key}", f"one of {', '.join(_ENVELOPE)}", "an unknown key"
            )
    return Scales(**envelope)


def _effects(
    path: Path, text: Mapping[str, Any], scales: Scales, catalogue: Catalogue
) -> tuple[dict[str, dict[str, float]], dict[str, dict[str, float]]]:
    """Values and standard deviations of every effect named in the file."""
    values: dict[str, dict[str, float]] = {}
    deviations: dict[str, dict[str, float]] = {}
    for name, entries in text.items():
        try:
            effect = catalogue[str(name)]
        except UnknownName as error:
            raise InputError(
                path, f"effects.{name}", "an effect of the catalogue", str(error)
            ) from error
        values[name], deviations[name] = {}, {}
        entries = _mapping(path, f"effects.{name}", entries)
        for key in entries:
            if key not in effect.names:
                expected = f"one of {', '.join(effect.names)}"
                raise InputError(path, f"effects.{name}.{key}", expected, "an unknown key")
        for q in effect.parameters:
            where = f"effects.{name}.{q.name}"
            if q.name not in entries:
                if q.name in effect.unsaid:
                    continue
                raise InputError(path, where, f"a value in {q.unit}", "nothing")
            value, sd = _value(path, where, entries[q.name], q.unit)
            low, high = q.low * scales.of(q.unit), q.high * scales.of(q.unit)
            if not (low <= value <= high) and value != q.neutral:
                raise InputError(path, where, f"{low:.4g} to {high:.4g} {q.unit}", f"{value:.6g}")
            values[name][q.name] = value
            if sd is not None:
                deviations[name][q.name] = sd
    return values, {name: found for name, found in deviations.items() if found}


def _value(path: Path, where: str, found: Any, unit: str) -> tuple[float, float | None]:
    """Value and standard deviation of a plain number or of {value, sd, unit}."""
    if not isinstance(found, dict):
        return _number(path, where, found), None
    for key in found:
        if key not in _VALUE_KEYS:
            raise InputError(
                path, f"{where}.{key}", f"one of {', '.join(_VALUE_KEYS)}", "an unknown key"
            )
    if found.get("unit", unit) != unit:
        raise InputError(path, f"{where}.unit", unit, found["unit"])
    sd = _number(path, f"{where}.sd", found["sd"]) if "sd" in found else None
    return _number(path, f"{where}.value", found.get("value")), sd

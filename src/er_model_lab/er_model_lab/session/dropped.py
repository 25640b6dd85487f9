"""Files that were dropped onto a page: what they may be called, be, and hold, and where they go."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from er_models.errors import InputError
from er_models.model import Model
from er_models.yaml_file import read_yaml
from er_records.load import READERS

LARGEST = 1 << 30
"""Most bytes of one file that is dropped."""
LARGEST_MODEL = 1 << 20
"""Most bytes of a model file."""
MODEL, CODE, SESSION = (".yaml", ".yml"), ".py", ".zip"
LONGEST_NAME = 100


def safe_name(name: str) -> str:
    """The name alone under which a dropped file is kept, whatever its sender calls it."""
    last = re.split(r"[/\\]", name)[-1]
    plain = re.sub(r"[^\w.\- ()\[\]]", "_", last).strip(" .")
    stem, dot, suffix = plain.rpartition(".")
    return f"{(stem if dot else suffix)[:LONGEST_NAME] or 'file'}{dot}{suffix if dot else ''}"


def place_for(folder: Path, name: str) -> Path:
    """A free place for a dropped file, inside the folder."""
    wanted = folder / safe_name(name)
    numbered = (wanted.with_stem(f"{wanted.stem}_{k}") for k in range(2, 10_000))
    return wanted if not wanted.exists() else next(p for p in numbered if not p.exists())


def kind_of(name: str, *, code: bool) -> str:
    """What a dropped file is: data, model, session or code.

    Raises:
        InputError: A file of another kind; code where it is not allowed.
    """
    suffix = Path(safe_name(name)).suffix.lower()
    if suffix == CODE and not code:
        raise InputError(
            name, "", "no program: it would run with your rights (--allow-code lets it)", "Python"
        )
    kinds = {
        **dict.fromkeys(READERS, "data"),
        **dict.fromkeys(MODEL, "model"),
        CODE: "code",
        SESSION: "session",
    }
    if suffix not in kinds:
        raise InputError(name, "suffix", f"one of {', '.join(kinds)}", f"'{suffix}'")
    return kinds[suffix]


def model_of(path: Path, effects_from: Sequence[Path] = ()) -> Model:
    """The model of a dropped file, which may name no other file.

    Raises:
        InputError: No model, a large file, or one that names another.
    """
    from er_model_lab.verbs.load import load_model

    if path.stat().st_size > LARGEST_MODEL:
        raise InputError(
            path.name, "", f"at most {LARGEST_MODEL >> 20} MB", f"{path.stat().st_size} bytes"
        )
    found = read_yaml(path, "a model file")
    if isinstance(found, dict) and "damper" in found:
        raise InputError(
            path.name, "damper", "a damper; a car's file names another one", found["damper"]
        )
    return load_model(path, effects_from)

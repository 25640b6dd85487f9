"""Files that were dropped onto a page: what they may be called, be, and hold, and where they go."""

from __future__ import annotations

import re
import shutil
import zipfile
from collections.abc import Sequence
from pathlib import Path

from er_models.errors import InputError
from er_models.model import Model
from er_models.yaml_file import read_yaml
from er_records.load import READERS
from er_records.readers.bag_files import METADATA

LARGEST = 1 << 30
"""Most bytes of one file that is dropped."""
LARGEST_MODEL = 1 << 20
"""Most bytes of a model file."""
MODEL, CODE, ZIP = (".yaml", ".yml"), ".py", ".zip"
STEPS = "session.json"
"""What every kept session has in its file."""
LONGEST_NAME = 100
MOST_PACKED = 50
"""Most measurements of one zip file."""


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
    """What a dropped file is: data, model, zip (a session or measurements) or code.

    Raises:
        InputError: A file of another kind; code where it is not allowed; what only lies beside a bag.
    """
    if Path(safe_name(name)).name == METADATA:
        raise InputError(
            name, "", "the bag itself (.mcap, .db3, or all of it as .zip)", "its metadata"
        )
    suffix = Path(safe_name(name)).suffix.lower()
    if suffix == CODE and not code:
        raise InputError(
            name, "", "no program: it would run with your rights (--allow-code lets it)", "Python"
        )
    kinds = {
        **dict.fromkeys(READERS, "data"),
        **dict.fromkeys(MODEL, "model"),
        CODE: "code",
        ZIP: "zip",
    }
    if suffix not in kinds:
        raise InputError(name, "suffix", f"one of {', '.join(kinds)}", f"'{suffix}'")
    return kinds[suffix]


def is_session(path: Path) -> bool:
    """Whether a zip file holds a session; what is no zip file is said to be one, whose reader says more."""
    try:
        with zipfile.ZipFile(path) as whole:
            return STEPS in whole.namelist()
    except (zipfile.BadZipFile, ValueError):
        return True


def measurements_of(path: Path, folder: Path) -> list[Path]:
    """The measurements of a zip file, such as a bag, laid into the folder under names of our own.

    Raises:
        InputError: None, or more than may be dropped.
    """
    with zipfile.ZipFile(path) as whole:
        found = [i for i in whole.infolist() if Path(i.filename).suffix.lower() in READERS]
        if not found or len(found) > MOST_PACKED:
            expected = f"a session, or 1 to {MOST_PACKED} measurements such as a bag"
            raise InputError(path.name, "", expected, f"{len(found)} measurements")
        if sum(i.file_size for i in found) > LARGEST:
            raise InputError(path.name, "", f"at most {LARGEST >> 30} GB unpacked", "more")
        laid = []
        for info in found:
            laid.append(place_for(folder, info.filename))
            with whole.open(info) as packed, laid[-1].open("wb") as out:
                shutil.copyfileobj(packed, out)
    return laid


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

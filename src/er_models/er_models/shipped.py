"""What comes with the package: models, gains, experiments and the effects' cards.

In the repository they lie in `config/` and `docs/effects`, to which the folder `data` links; a wheel holds copies.
"""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from er_models.errors import InputError

MODELS = ("dampers", "vehicles")
"""Kinds of what `load_model` reads."""
_SUFFIX = {"cards": ".md"}


def names(*kinds: str) -> tuple[str, ...]:
    """Names of what is shipped of some kinds, without suffix, in order.

    kinds: `dampers`, `vehicles`, `gains`, `experiments`, `cards`.
    """
    return tuple(sorted({path.stem for kind in kinds for path in _all(kind)}))


def shipped(name: str, *kinds: str) -> Path:
    """The file of a name, of the first of some kinds that has it.

    Raises:
        InputError: No such name; the message lists what there is.
    """
    for kind in kinds:
        for path in _all(kind):
            if path.stem == name:
                return path
    known = f"{' or '.join(kinds)}: {', '.join(names(*kinds))}"
    raise InputError(name, "", f"a path, or a name among the shipped {known}", "neither")


def file_of(given: str | Path, *kinds: str) -> Path:
    """The file that is meant by a path, or by the name of something shipped of these kinds.

    A path is what has a suffix or a folder, or is a file; all else is a name.

    Raises:
        InputError: A name that is not shipped; the message lists what is.
    """
    path = Path(given)
    if path.suffix or path.parent != Path() or path.is_file():
        return path
    return shipped(path.name, *kinds)


def _all(kind: str) -> list[Path]:
    """Files of a kind, without the list of all cards; a package with compiled code is always unpacked."""
    folder = Path(str(files("er_models").joinpath("data", kind)))
    return list(folder.glob(f"[a-z]*{_SUFFIX.get(kind, '.yaml')}"))

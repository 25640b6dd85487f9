"""What was worked out once is found again: results in the cache folder, by all that decides them."""

from __future__ import annotations

import hashlib
import logging
import pickle
import platform
from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from typing import TypeVar

from er_models.cache import sealed
from er_models.cache.folder import state_folder
from er_models.cache.sources import state

Result = TypeVar("Result")
FEW = 24
"""Results that are kept, those last made."""
LARGEST = 1 << 26
"""Largest result that is kept [bytes]."""
LIBRARIES = ("numba", "numpy", "scipy")
"""Whose versions count, too."""
ENDING = ".result"
_LOG = logging.getLogger(__name__)


def kept(packages: Sequence[str], decides: object, make: Callable[[], Result]) -> Result:
    """What `make` gives, from the cache where it was made before by the same sources from equal `decides`.

    packages: all whose sources make it, that which keeps it first; decides: all that the result follows from; it and
    the result can be pickled. The file is read as compiled code is, only as this user has written it: see
    `er_models.cache.sealed`.
    """
    folder, name = state_folder(state(packages[0])[0]), _name(packages, decides)
    if (content := sealed.read(folder, name)) is not None:
        found: Result = pickle.loads(content)
        return found
    result = make()
    content = pickle.dumps(result, protocol=5)
    if len(content) <= LARGEST:
        try:
            sealed.write(folder, name, content)
            _tidy(folder)
        except OSError as error:
            _LOG.warning("%s: %s: the result is not kept", folder, error.strerror)
    return result


def _name(packages: Sequence[str], decides: object) -> str:
    """Name of the file of a result."""
    made_by = (
        platform.python_version(), *map(version, LIBRARIES), *(state(name)[0] for name in packages)
    )  # fmt: skip
    digest = hashlib.sha256(pickle.dumps((decides, made_by), protocol=5))
    return digest.hexdigest()[:32] + ENDING


def _tidy(folder: Path) -> None:
    """Remove what was made long ago; another process may do so, too."""
    with suppress(OSError):
        for old in sorted(folder.glob(f"*{ENDING}"), key=lambda f: f.stat().st_mtime)[:-FEW]:
            old.unlink()

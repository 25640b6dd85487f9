"""Makes the kernel module of a catalogue; its compiled functions are kept on disk."""

from __future__ import annotations

import contextlib
import marshal
import sys
from functools import lru_cache
from pathlib import Path
from types import CodeType, ModuleType

import numpy as np
from numpy.typing import NDArray

from er_models.cache import sealed
from er_models.cache.folder import state_folder, tell
from er_models.cache.sources import state
from er_models.catalogue import Catalogue
from er_models.kernel import hooks
from er_models.kernel.compose import fingerprint, source


@lru_cache(maxsize=8)
def kernel(catalogue: Catalogue) -> ModuleType:
    """Kernel module of a catalogue.

    Its source lies on disk to be read; what is executed is the text that was composed here.
    """
    name, text = f"er_kernel_{fingerprint(catalogue)}", source(catalogue)
    path = state_folder(state(__name__)[0]) / f"{name}.py"
    _show(path, text.encode())
    module = ModuleType(name)
    module.__file__ = str(path)
    sys.modules[name] = module
    hooks.use(catalogue)
    exec(_code(path, text), module.__dict__)
    return module


def _code(path: Path, text: str) -> CodeType:
    """The text as Python has read it, which is kept as well: it takes 15 ms."""
    place = f"{path.stem}.{sys.implementation.cache_tag}.code"
    found = sealed.read(path.parent, place)
    code: CodeType | None = None if found is None else marshal.loads(found)
    if code is None or code.co_filename != str(path):  # the cache was moved
        code = compile(text, str(path), "exec")
        with contextlib.suppress(OSError):
            sealed.write(path.parent, place, marshal.dumps(code))
    return code


def _show(path: Path, text: bytes) -> None:
    """Write the source where it can be read, unless it lies there."""
    try:
        if path.exists():
            if path.read_bytes() == text:
                return
            tell(path, "it is not the source of this kernel, and is made anew")
        sealed.put(path, text)
    except OSError as error:
        tell(path, f"{error.strerror}: the source of the kernel is not written")


def plain(samples: NDArray[np.float64]) -> NDArray[np.float64]:
    """Samples as the kernels are compiled for: contiguous and writable; a copy where they are not.

    Read-only samples are another type to Numba, and a type of its own is a compilation of its own, seconds long.
    """
    flags = samples.flags
    return samples if flags.c_contiguous and flags.writeable else np.array(samples)

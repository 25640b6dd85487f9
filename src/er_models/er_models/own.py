"""A user's own effects, from Python files outside the package.

A file holds `EFFECT = Effect(...)`, or `EFFECTS` with several. What is loaded is checked here, once,
so that whatever is wrong with it is one clear line and not an error of the compiler.
"""

from __future__ import annotations

import hashlib
import linecache
import sys
import traceback
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from types import ModuleType

from er_models.catalogue import CATALOGUE, Catalogue, Origin
from er_models.effect import Effect
from er_models.errors import InputError
from er_models.own_check import check


def catalogue_with(files: Sequence[str | Path]) -> Catalogue:
    """The catalogue with the effects of these files at its end, in their order; the same one for the same files.

    Raises `InputError` naming file and what is wrong: no file, no Python, an error while it runs, no
    effect, a name that is taken, or an effect that cannot be used (`er_models.own_check`).
    """
    paths = tuple(dict.fromkeys(Path(file).resolve() for file in files))
    return _catalogue(tuple((path, _content(path)) for path in paths)) if paths else CATALOGUE


@lru_cache(maxsize=8)
def _catalogue(files: tuple[tuple[Path, bytes], ...]) -> Catalogue:
    """The catalogue with the effects of files of this content, which another process need not have."""
    catalogue = CATALOGUE
    for path, content in files:
        digest = hashlib.sha256(content).hexdigest()
        effects = _effects(path, _module(path, content, digest))
        for i, effect in enumerate(effects):
            if effect.name in (*catalogue.names, *(e.name for e in effects[:i])):
                raise InputError(path, "name", "a name that no other effect has", effect.name)
            check(path, effect, (*catalogue.names, *(e.name for e in effects)))
        origin = Origin(path.name, digest)
        own = {e.name: origin for e in effects}
        catalogue = catalogue.extended(effects, own, made=(_catalogue, (files,)))
    return catalogue


def _content(path: Path) -> bytes:
    """Content of a file."""
    if not path.is_file():
        found = "no file" if not path.exists() else "a folder"
        raise InputError(path, "", "a Python file with effects", found)
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(path, "", "a file that can be read", error.strerror or error) from error


def _module(path: Path, content: bytes, digest: str) -> ModuleType:
    """The file run as a module, kept among the modules so that its source is found again."""
    name = f"er_own_{path.stem}_{digest[:16]}"
    module = ModuleType(name)
    module.__file__ = str(path)
    sys.modules[name] = module
    text = content.decode(errors="replace")
    linecache.cache[str(path)] = (len(content), None, text.splitlines(keepends=True), str(path))
    try:
        exec(compile(content, str(path), "exec"), module.__dict__)
    except SyntaxError as error:
        del sys.modules[name]
        raise InputError(path, f"line {error.lineno}", "valid Python", error.msg) from error
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        raise InputError(path, _line(path, error), "a file that runs", _said(error)) from error
    return module


def _line(path: Path, error: BaseException) -> str:
    """The last line of the file that an error came through."""
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if frame.filename == str(path)]
    return f"line {lines[-1]}" if lines else ""


def _said(error: BaseException) -> str:
    """An error in one line; of our own only its words."""
    words = " ".join(str(error).split())
    return words if isinstance(error, ValueError) and words else f"{type(error).__name__}: {words}"


def _effects(path: Path, module: ModuleType) -> tuple[Effect, ...]:
    """What a file gives as EFFECT or EFFECTS."""
    found = getattr(module, "EFFECTS", None) or getattr(module, "EFFECT", None)
    if found is None:
        expected = "EFFECT = Effect(...), or EFFECTS with several"
        raise InputError(path, "EFFECT", expected, "neither")
    effects = tuple(found) if isinstance(found, list | tuple) else (found,)
    for effect in effects:
        if not isinstance(effect, Effect):
            raise InputError(path, "EFFECT", "an Effect", type(effect).__name__)
    return effects

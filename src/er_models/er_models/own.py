"""A user's own effects, from Python files outside the package.

A file holds `EFFECT = Effect(...)`, or `EFFECTS` with several. What is loaded is checked here, once,
so that whatever is wrong with it is one clear line and not an error of the compiler.

Such a file is a program and runs with all rights of who loads it: give only files whose author you trust. Before it
runs it is looked at whether it is one at all, and one that others cannot have changed.
"""

from __future__ import annotations

import hashlib
import linecache
import sys
import traceback
from collections.abc import Sequence
from functools import lru_cache
from importlib.util import decode_source
from pathlib import Path
from symtable import symtable
from types import CodeType, ModuleType

from er_models.cache.owned import ALL_WRITE, read_owned
from er_models.catalogue import CATALOGUE, Catalogue, Origin
from er_models.effect import Effect
from er_models.errors import InputError
from er_models.own_check import check

LARGEST = 1 << 20
"""A file of effects has this many bytes at most."""
NAMES = ("EFFECT", "EFFECTS")
EXPECTED = "EFFECT = Effect(...), or EFFECTS with several"


def effects(files: Sequence[str | Path] = ()) -> Catalogue:
    """The catalogue: every effect in order, by name in brackets; the same one for the same files.

    files: Python files with effects of your own (`EFFECT` or `EFFECTS`), which follow in their order.

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
    """Content of a file of this user, of root or of the owner of this program, and that not everybody may write to."""
    if path.is_dir() or not path.exists():
        found = "a folder" if path.is_dir() else "no file"
        raise InputError(path, "", "a Python file with effects", found)
    try:
        return read_owned(path, ALL_WRITE, (Path(__file__).stat().st_uid,), LARGEST)
    except PermissionError as error:
        expected = f"a file of yours that can be read, {LARGEST >> 20} MB at most"
        raise InputError(path, "", expected, error.strerror) from error
    except OSError as error:
        raise InputError(path, "", "a file that can be read", error.strerror or error) from error


def _module(path: Path, content: bytes, digest: str) -> ModuleType:
    """The file run as a module, kept among the modules so that its source is found again."""
    code = _code(path, content)
    name = f"er_own_{path.stem}_{digest[:16]}"
    module = ModuleType(name)
    module.__file__ = str(path)
    sys.modules[name] = module
    text = content.decode(errors="replace")
    linecache.cache[str(path)] = (len(content), None, text.splitlines(keepends=True), str(path))
    try:
        exec(code, module.__dict__)
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        raise InputError(path, _line(path, error), "a file that runs", _said(error)) from error
    return module


def _code(path: Path, content: bytes) -> CodeType:
    """The file as Python reads it, where that gives an effect a name; nothing of it has run."""
    try:
        text = decode_source(content)
        code = compile(text, str(path), "exec")
        symbols = symtable(text, str(path), "exec").get_symbols()
    except SyntaxError as error:
        raise InputError(path, f"line {error.lineno}", "valid Python", error.msg) from error
    except (ValueError, RecursionError, MemoryError) as error:
        raise InputError(path, "", "valid Python", _said(error)) from error
    given = {each.get_name() for each in symbols if each.is_assigned() or each.is_imported()}
    if not given.intersection(NAMES):
        raise InputError(path, NAMES[0], EXPECTED, "neither")
    return code


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
    found = getattr(module, NAMES[1], None) or getattr(module, NAMES[0], None)
    if found is None:
        raise InputError(path, NAMES[0], EXPECTED, "neither")
    effects = tuple(found) if isinstance(found, list | tuple) else (found,)
    for effect in effects:
        if not isinstance(effect, Effect):
            raise InputError(path, "EFFECT", "an Effect", type(effect).__name__)
    return effects

"""A session as one file: its program, every step with its model, and the data that were dropped."""

from __future__ import annotations

import io
import json
import math
import zipfile
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from er_models.errors import ErError, InputError
from er_models.files import save_model
from er_models.model import Model

from er_model_lab.session.dropped import (
    LARGEST,
    LARGEST_MODEL,
    STEPS,
    kind_of,
    model_of,
    place_for,
    safe_name,
)
from er_model_lab.session.script import script
from er_model_lab.session.steps import Session, Source, State, Step, Stretch, files_of

SCHEMA = "er_lab_session/1"
MOST = 10_000
"""Most entries of a session's file."""


def model_text(model: Model) -> str:
    """The model as its file would hold it."""
    with TemporaryDirectory(prefix="er_lab_") as folder:
        path = Path(folder) / "model.yaml"
        save_model(model, path)
        return path.read_text(encoding="utf-8")


def packed(session: Session, folder: Path) -> bytes:
    """The session as a zip file: what lies in `folder`, where dropped files are kept, is in it, all else is named."""
    inside = {
        p: f"data/{p.name}"
        for p in files_of(session) if p.is_relative_to(folder) and p.is_file()
    }  # fmt: skip
    models, out = dict[str, str](), io.BytesIO()

    def named(model: Model | None) -> str | None:
        return (
            None
            if model is None
            else models.setdefault(model_text(model), f"models/{len(models)}.yaml")
        )

    def place(path: Path) -> str:
        return inside.get(path, str(path))

    steps = [
        {
            "step": [s.step.kind, s.step.what, _placed(dict(s.step.values), place)],
            "sources": [[place(f.path), None if f.names is None else dict(f.names)] for f in s.sources],
            "held": [[h.record, h.start, h.end if math.isfinite(h.end) else None] for h in s.held],
            "model": named(s.model), "fitted": named(s.fitted), "off": {k: dict(v) for k, v in s.off.items()},
        }
        for s in session.past
    ]  # fmt: skip
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as whole:
        content = {"schema": SCHEMA, "seed": session.seed, "steps": steps}
        whole.writestr(STEPS, json.dumps(content, indent=1))
        whole.writestr("session.py", script(session, place))
        for text, name in models.items():
            whole.writestr(name, text)
        for path, name in inside.items():
            whole.write(path, name)
    return out.getvalue()


def _placed(values: dict[str, Any], place: Any) -> dict[str, Any]:
    """The values of a step with the files that it names where the session has them."""
    if "from" in values and Path(str(values["from"])).suffix:
        values["from"] = place(Path(str(values["from"])))
    if "effects_from" in values:
        values["effects_from"] = [place(Path(str(path))) for path in values["effects_from"]]
    return values


def unpacked(
    path: Path, folder: Path, given: Sequence[Path] = (), *, code: bool = False
) -> Session:
    """The session of a file; its data go to `folder`, under names of our own.

    given: paths beside those in the file that it may name; code: whether its Python files may run.

    Raises:
        InputError: No session, one that is too large, or that names a file that is neither in it nor given.
    """
    try:
        with zipfile.ZipFile(path) as whole:
            return _unpacked(whole, path, folder, [p.resolve() for p in given], code=code)
    except (
        zipfile.BadZipFile,
        KeyError,
        ValueError,
        TypeError,
        IndexError,
        AttributeError,
    ) as error:
        if isinstance(error, ErError):
            raise
        raise InputError(
            path.name,
            "",
            "a session that was taken from this page",
            f"{type(error).__name__}: {error}",
        ) from None


def _unpacked(
    whole: zipfile.ZipFile, path: Path, folder: Path, given: Sequence[Path], *, code: bool
) -> Session:
    entries = {i.filename: i for i in whole.infolist()}
    if len(entries) > MOST or sum(i.file_size for i in entries.values()) > LARGEST:
        raise InputError(
            path.name, "", f"at most {MOST} files of {LARGEST >> 30} GB together", "more"
        )
    content = json.loads(whole.read(STEPS))
    if content["schema"] != SCHEMA:
        raise InputError(path.name, "schema", SCHEMA, content["schema"])
    kept, models, own = dict[str, Path](), dict[str, Model](), list[Path]()

    def file(name: str) -> Path:
        """A file of the session, laid into the folder, or one that was given."""
        if name not in entries:
            if Path(name).resolve() in given:
                return Path(name)
            raise InputError(
                path.name, "", "files that are in it, or were named on the command line", name
            )
        if name not in kept:
            kind_of(name, code=code)
            kept[name] = place_for(folder, safe_name(name))
            kept[name].write_bytes(whole.read(name))
        return kept[name]

    def model(name: str | None) -> Model | None:
        if name is None:
            return None
        if name not in models:
            with TemporaryDirectory(prefix="er_lab_") as place:
                text = Path(place) / "model.yaml"
                text.write_bytes(whole.read(name)[: LARGEST_MODEL + 1])
                models[name] = model_of(text, own)
        return models[name]

    def state(s: dict[str, Any]) -> State:
        kind, what, values = s["step"]
        if kind == "start":
            values |= _placed(values, lambda path: str(file(str(path))))
            own[:] = map(Path, values.get("effects_from", ()))
        sources = tuple(Source(file(p), names) for p, names in s["sources"])
        held = tuple(Stretch(k, a, math.inf if b is None else b) for k, a, b in s["held"])
        step = Step(kind, what, values)
        return State(step, sources, held, model(s["model"]), model(s["fitted"]), s["off"])

    return Session(tuple(map(state, content["steps"])), seed=int(content["seed"]))

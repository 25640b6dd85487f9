"""The session as a program: the library's calls that make the same result."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from er_models.measured import is_term

from er_model_lab.session.steps import Piece, Session, Source, State, Step, files_of

Place = Callable[[Path], str]
"""Where the program finds a file."""
HEAD = '''"""A session of the model lab as a program: {name}.{beside}"""

import er_model_lab as lab

SEED = {seed}

if __name__ == "__main__":
'''
BESIDE = """

Run it in a folder that holds what was dropped:
{}
Session, taken from the page, is all of this in one file.
"""
FITTED = "data, model, {}seed=SEED, anyway=True).model"


def alone(session: Session, folder: Path) -> str:
    """The program for whoever has it alone: it says which files belong beside it, and names all others in full.

    folder: where dropped files are kept, which nobody else finds.
    """
    dropped = {p: p.name for p in files_of(session) if p.is_relative_to(folder)}
    return script(session, lambda p: dropped.get(p, str(p.resolve())), [*dropped.values()])


def script(session: Session, place: Place = str, beside: Sequence[str] = ()) -> str:
    """The Python program of every step that still counts; it prints the error and writes model.yaml.

    place: where the program finds a file; beside: files that its head asks for.
    """
    lines, before, now = list[str](), State(), session.now
    for state in session.past:
        if state.sources != before.sources:
            loads = ", ".join(f"*{_load(s, place)}" for s in state.sources)
            lines += [f"records = [{loads}]", "data = lab.Dataset.of(records)"]
        lines += _line(state.step, place)
        before = state
    if now.sources and now.model is not None:
        lines += [
            "result = lab.compare(data, model, seed=SEED, anyway=True)",
            'print(f"error {result.rmse:.6g} N")',
        ]
    if now.model is not None:
        lines.append('lab.save_model(model, "model.yaml")')
    name = now.model.name if now.model else "no model yet"
    head = HEAD.format(name=name, seed=session.seed, beside=_beside(beside))
    return head + "".join(f"    {line}\n" for line in lines or ["pass"])


def _beside(files: Sequence[str]) -> str:
    return BESIDE.format("\n".join(f"    {name}" for name in files)) if files else ""


def _load(source: Source, place: Place) -> str:
    """Loading a file."""
    names = "" if source.names is None else f", names={dict(source.names)!r}"
    return f"lab.load({place(source.path)!r}{names}).records"


def _line(step: Step, place: Place) -> list[str]:
    """What a step makes of data and model."""
    what, values = step.what, dict(step.values)
    for told in ("parameter", "fall"):
        values.pop(told, None)
    makers: Mapping[str, Callable[[], str]] = {
        "hold": lambda: (
            f"data = lab.Dataset.of({_cuts(values['learn'])}, {_cuts(values['score'])})"
        ),
        "start": lambda: f"model = fitted = lab.load_model({_start(values, place)})",
        "new": lambda: (
            f"model = fitted = lab.new(data, {values['kind']!r}, name={what!r}, anyway=True)"
        ),
        "set": lambda: f"model = model.with_effect({what!r}, {values!r})",
        "on": lambda: f"model = model.with_effect({what!r}, {values!r})",
        "off": lambda: f"model = model.without_effect({what!r})",
        "fitted": lambda: "model = fitted",
        "add": lambda: f"model = fitted = lab.add({FITTED.format(f'{what!r}, ')}",
        "back": lambda: f"model = fitted = lab.refit({_less(what)}, seed=SEED, anyway=True)",
        "improve": lambda: f"model = fitted = lab.improve({FITTED.format(_options(values))}",
    }
    return [makers[step.kind]()] if step.kind in makers else []


def _less(name: str) -> str:
    """What is refitted once an effect or a measured term was taken back."""
    kind = "term" if is_term(name) else "effect"
    return f"data, model.without_{kind}({name!r})"


def _cuts(cut: Sequence[Piece]) -> str:
    """Records, and parts of them."""
    return f"[{', '.join(f'records[{k}]' + (f'.slice({rows[0]}, {rows[1]})' if rows else '') for k, *rows in cut)}]"


def _start(values: Mapping[str, Any], place: Place) -> str:
    """The file of a model, or its shipped name, and the files with effects that it may have."""
    path = Path(str(values["from"]))
    code = [place(Path(file)) for file in values.get("effects_from", ())]
    own = f", effects_from={code!r}" if code else ""
    return f"{place(path) if path.suffix else str(values['from'])!r}{own}"


def _options(values: Mapping[str, Any]) -> str:
    return "".join(f"{k}={v!r}, " for k, v in values.items())

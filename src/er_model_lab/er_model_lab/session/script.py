"""The session as a program: the library's calls that make the same result."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from er_model_lab.session.steps import Piece, Session, Source, State, Step

Place = Callable[[Path], str]
"""Where the program finds a file."""
HEAD = '''"""A session of the model lab as a program: {name}."""

import er_model_lab as lab

SEED = {seed}

if __name__ == "__main__":
'''
FITTED = "data, model, {}seed=SEED, anyway=True).model"


def script(session: Session, place: Place = str) -> str:
    """The Python program of every step that still counts; it prints the error and writes model.yaml.

    place: where the program finds a file.
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
    head = HEAD.format(name=now.model.name if now.model else "no model yet", seed=session.seed)
    return head + "".join(f"    {line}\n" for line in lines or ["pass"])


def _load(source: Source, place: Place) -> str:
    """Loading a file."""
    names = "" if source.names is None else f", names={dict(source.names)!r}"
    return f"lab.load({place(source.path)!r}{names}).records"


def _line(step: Step, place: Place) -> list[str]:
    """What a step makes of data and model."""
    what, values = step.what, dict(step.values)
    values.pop("parameter", None)
    makers: Mapping[str, Callable[[], str]] = {
        "hold": lambda: (
            f"data = lab.Dataset.of({_cuts(values['learn'])}, {_cuts(values['score'])})"
        ),
        "start": lambda: f"model = fitted = lab.load_model({_origin(values['from'], place)!r})",
        "set": lambda: f"model = model.with_effect({what!r}, {values!r})",
        "on": lambda: f"model = model.with_effect({what!r}, {values!r})",
        "off": lambda: f"model = model.without_effect({what!r})",
        "fitted": lambda: "model = fitted",
        "add": lambda: f"model = fitted = lab.add({FITTED.format(f'{what!r}, ')}",
        "improve": lambda: f"model = fitted = lab.improve({FITTED.format(_options(values))}",
    }
    return [makers[step.kind]()] if step.kind in makers else []


def _cuts(cut: Sequence[Piece]) -> str:
    """Records, and parts of them."""
    return f"[{', '.join(f'records[{k}]' + (f'.slice({rows[0]}, {rows[1]})' if rows else '') for k, *rows in cut)}]"


def _origin(origin: Any, place: Place) -> str:
    """The file of a model, or its shipped name."""
    path = Path(str(origin))
    return place(path) if path.suffix else str(origin)


def _options(values: Mapping[str, Any]) -> str:
    return "".join(f"{k}={v!r}, " for k, v in values.items())

"""The session as a program: the library's calls that make the same result."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from er_records.record import Record

from er_model_lab.session.steps import Piece, Session, State, Step, pieces

Place = Callable[[Path], str]
"""Where the program finds a file."""
HEAD = '''"""A session of the model lab as a program: {model}."""

import er_model_lab as lab

if __name__ == "__main__":
'''


def script(session: Session, records: Sequence[Record], place: Place = str) -> str:
    """The Python program of every step that still counts; it prints the errors and writes model.yaml.

    records: as the last data were loaded, for the rows that are held out; place: where the program finds a file.
    """
    lines, before = list[str](), State()
    for state in session.past:
        lines += _line(state, before, session, records, place)
        before = state
    if before.sources and before.model is not None:
        lines += ["result = lab.compare(data, model, seed=SEED)", 'print(f"error {result.rmse:.6g} N")']
    if before.model is not None:
        lines.append('lab.save_model(model, "model.yaml")')
    name = before.model.name if before.model else "no model yet"
    body = [f"SEED = {session.seed}", *lines]
    return HEAD.format(model=name) + "".join(f"    {line}\n" for line in body)


def _line(
    state: State, before: State, session: Session, records: Sequence[Record], place: Place
) -> list[str]:
    """What a step is in the library's words."""
    out = list[str]()
    if state.sources != before.sources:
        loads = [f"*{_load(s.path, s.names, place)}" for s in state.sources]
        out = [f"records = [{', '.join(loads)}]", "data = lab.Dataset.of(records)"]
    if state.held != before.held and state.sources:
        current = records if state.sources == session.now.sources else ()
        learn, score = pieces(current, state.held)
        out.append(f"data = lab.Dataset.of({_cuts(learn, current)}, {_cuts(score, current)})")
    return out + _model(state.step, place)


def _load(path: Path, names: object, place: Place) -> str:
    """Loading one source."""
    named = f", names={dict(names)!r}" if isinstance(names, dict) else ""
    return f"lab.load({place(path)!r}{named}).records"


def _cuts(cut: Sequence[Piece], records: Sequence[Record]) -> str:
    """Records and parts of them."""
    return f"[{', '.join(_cut(k, i, j, records) for k, i, j in cut)}]"


def _cut(k: int, i: int, j: int, records: Sequence[Record]) -> str:
    return f"records[{k}]" if j - i == len(records[k]) else f"records[{k}].slice({i}, {j})"


def _model(step: Step, place: Place) -> list[str]:
    """What a step makes of the model."""
    what, values = step.what, dict(step.values)
    if step.kind == "start":
        origin = str(values["from"])
        if kind := values.get("kind"):
            return [f"model = fitted = lab.new(data, {kind!r}, name={what!r})"]
        known = place(Path(origin)) if Path(origin).suffix else origin
        return [f"model = fitted = lab.load_model({known!r})"]
    values.pop("parameter", None)
    return {
        "set": [f"model = model.with_effect({what!r}, {values!r})"],
        "on": [f"model = model.with_effect({what!r}, {values!r})"],
        "off": [f"model = model.without_effect({what!r})"],
        "fitted": ["model = fitted"],
        "add": [f"model = fitted = lab.add(data, model, {what!r}, seed=SEED).model"],
        "improve": [f"model = fitted = lab.improve(data, model, {_options(values)}seed=SEED).model"],
    }.get(step.kind, [])


def _options(values: dict[str, object]) -> str:
    return "".join(f"{k}={v!r}, " for k, v in values.items())

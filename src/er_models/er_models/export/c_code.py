"""C code of one model: its parameters, its states, `init` and `step`, with the kernel's own integration.

The functions come from the source that `kernel.compose` writes for a catalogue of the model's effects alone
(`export.translate`). What carries them from sample to sample (`templates/damper.c`) does what `kernel.imposed`
does along a record, one step at a time.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from er_models.catalogue import Catalogue
from er_models.effect import Effect, Param
from er_models.errors import InputError
from er_models.export.translate import Program
from er_models.export.values import KEYWORDS, Source, Value, number, source_of, struct
from er_models.files import write_whole
from er_models.kernel import rows as kernel_rows
from er_models.kernel.compose import source
from er_models.kernel.inputs import ROUNDING
from er_models.kernel.order import reads
from er_models.kernel.rows import ROWS
from er_models.kernel.states import HOLD
from er_models.model import Model
from er_models.prediction import SUBSTEP
from er_models.version import __version__

TEMPLATES = Path(__file__).parent / "templates"
QUEUE = 1024
"""Changes of the duty, or forces, that a delay keeps: at 10 kHz those of a tenth of a second."""
NEEDED = ("passive", "response")
"""Effects that the composed kernel names whether a model has them or not."""
_HELPERS = {
    "lesser": "static double lesser(double a, double b) { return b < a ? b : a; }",
    "greater": "static double greater(double a, double b) { return b > a ? b : a; }",
    "modulo": "static double modulo(double a, double b)\n{\n    const double r = fmod(a, b);\n"
    "    return r != 0.0 && (r < 0.0) != (b < 0.0) ? r + b : r;\n}",
    "quotient": "static double quotient(double a, double b) { return floor((a - modulo(a, b)) / b + 0.5); }",
}
_IF = re.compile(r"^//if (not )?(\w+)\n(.*?)^//end\n", re.M | re.S)


@dataclass(frozen=True)
class Slot:
    """A parameter in C: `effect.name` in files, its place in the struct, its value and bounds [SI]."""

    effect: Effect
    param: Param
    value: float
    low: float
    high: float

    @property
    def name(self) -> str:
        """Its name beside others."""
        return f"{self.effect.name}.{self.param.name}"

    @property
    def member(self) -> str:
        """Its place in the struct of parameters."""
        return f"{identifier(self.effect.name)}.{identifier(self.param.name)}"

    @property
    def unit(self) -> str:
        """Its unit; the duty is a number."""
        return self.param.unit


def identifier(name: str) -> str:
    """A name as C takes it."""
    found = re.sub(r"\W", "_", name, flags=re.ASCII)
    return f"{found}_" if found in KEYWORDS else f"_{found}" if found[:1].isdigit() else found


@dataclass(frozen=True)
class CCode:
    """C code of the damper of a model."""

    model: Model

    @cached_property
    def damper(self) -> Model:
        """The model with a catalogue of its own effects alone, without those of the car."""
        whole = self.model
        names = [n for n in whole.effects if whole.catalogue[n].stage != "vehicle"]
        kept = [e for e in whole.catalogue.effects if e.name in {*names, *NEEDED}]
        catalogue = Catalogue(tuple(kept), whole.catalogue.origins)
        return replace(whole, effects={n: whole.effects[n] for n in names}, catalogue=catalogue)

    @cached_property
    def name(self) -> str:
        """What everything in C begins with."""
        return identifier(self.model.name)

    @cached_property
    def slots(self) -> tuple[Slot, ...]:
        """Parameters in the order of the catalogue."""
        d = self.damper
        return tuple(
            Slot(e, q, d.value(e.name, q.name), *d.bounds(e.name, q.name))
            for e in d.catalogue.effects if e.name in d.effects for q in e.parameters
        )  # fmt: skip

    @cached_property
    def reads_temperature(self) -> bool:
        """Whether the temperature matters."""
        return reads((self.damper.catalogue[n] for n in self.damper.effects), "theta")

    @cached_property
    def files(self) -> Mapping[str, str]:
        """Header and source by their names.

        Raises:
            Untranslatable: a hook uses what has no form in C.
        """
        program = self._program()
        code = "\n\n".join(program.functions)
        tuples = "\n".join(
            f"typedef struct {{ {' '.join(f'{k} v{i};' for i, k in enumerate(kind))} }} {struct(kind)};"
            for kind in program.tuples.values() if isinstance(kind, tuple)
        )  # fmt: skip
        tables = "\n".join(
            f"static const int {name}[] = {{{', '.join(map(str, values))}}};"
            for name, values in program.tables.items()
        )
        helpers = "\n".join(
            line
            for name, line in _HELPERS.items()
            if f"{name}(" in code
            or name == "greater"
            or (name == "modulo" and "quotient(" in code)
        )
        rows = f"enum {{ {', '.join(self._rows)} }}; /* rows of the states */"
        told = {
            "types": "\n".join(filter(None, (rows, tuples, tables, helpers))),
            "functions": code,
        }
        return {
            f"{self.name}.h": self.filled("damper.h", told),
            f"{self.name}.c": self.filled("damper.c", told),
        }

    def filled(self, template: str, more: Mapping[str, str]) -> str:
        """A template with what is known of the model put in."""
        c = self.damper.catalogue
        has = {hook for n in self.damper.effects for hook in c[n].hooks}
        text = (TEMPLATES / template).read_text(encoding="utf-8")
        text = _IF.sub(lambda m: m[3] if (m[2] in has) != bool(m[1]) else "", text)
        words = {
            "NAME": self.name, "GUARD": f"{self.name.upper()}_H", "title": _line(self._title), "version": __version__,
            "digest": self.model.digest(), "ROWS": ROWS, "STATES": c.n_states, "QUEUE": QUEUE, "HOLD": HOLD,
            "SUBSTEP": repr(SUBSTEP), "ROUNDING": repr(ROUNDING), "parameters": self._struct(),
            "defaults": "\n".join(f"    p->{s.member} = {number(s.value).text};" for s in self.slots), **more,
        }  # fmt: skip
        return re.sub(r"@(\w+)@", lambda m: str(words[m[1]]), text)

    @property
    def _title(self) -> str:
        source = f"; {self.model.source}" if self.model.source else ""
        return f"Damper {self.model.name}: {', '.join(self.damper.effects)}{source}"

    def _struct(self) -> str:
        """Members of the struct of parameters, one struct an effect."""
        lines = []
        for effect in dict.fromkeys(s.effect for s in self.slots):
            own = [s for s in self.slots if s.effect is effect]
            lines += [f"    struct {{ /* {_line(effect.title)} */"]
            lines += [
                f"        double {identifier(s.param.name)}; /* {_line(_told(s))} */" for s in own
            ]
            lines += [f"    }} {identifier(effect.name)};"]
        return "\n".join(lines) or "    int none;"

    @cached_property
    def _names(self) -> dict[str, Any]:
        """What names mean in the composed kernel: constants, its functions, hooks that it calls."""
        c = self.damper.catalogue
        names: dict[str, Any] = {"math": math, "np": np, "exp": math.exp, "tanh": math.tanh}
        tree = ast.parse(source(c))
        for node in tree.body:
            if isinstance(node, ast.FunctionDef):
                names[node.name] = Source(f"the kernel, {node.name}", node, names, node.name)
            elif isinstance(node, ast.Assign) and "_compiled" not in ast.unparse(node.value):
                exec(ast.unparse(node), names)
        for effect in c.effects:
            for hook, function in effect.hooks.items():
                called = f"{effect.name}__{hook}"
                if f"{called} = " in source(c):
                    names[called] = source_of(function, identifier(called))
        return names

    @cached_property
    def _rows(self) -> list[str]:
        """Names of the rows of the states, in order."""
        rows = {v: k for k, v in vars(kernel_rows).items() if k.isupper()}
        return [rows[i] for i in range(ROWS)]

    def _program(self) -> Program:
        """All functions that the step needs."""
        d, made = self.damper, self.damper.compiled()
        program = Program(self._columns(), (ROWS, d.catalogue.n_states))
        known = {
            name: Value(name, "table", known=getattr(made, name)) for name in ("on", "slots", "links", "at_rest")
        } | {"p": Value("p", "params"), "s": Value("s", "states")}  # fmt: skip
        hooks = {hook for n in d.effects for hook in d.catalogue[n].hooks}
        delays = [h for h in ("input_delay", "output_delay") if h in hooks]
        for name in ("solve", "keep", "settle", *delays):
            self._call(program, name, known)
        for name in ("cubic", "at", *(["hermite"] if "output_delay" in hooks else [])):
            self._call(program, name, {"c": Value("c", ("double",) * 4)})
        return program

    def _call(self, program: Program, name: str, known: Mapping[str, Value]) -> None:
        """Translate a function of the kernel; what its arguments are where they are no numbers."""
        source: Source = self._names[name]
        arguments = [a.arg for a in source.tree.args.args]
        program.call(source, [known.get(a, Value(a, "double")) for a in arguments])

    def _columns(self) -> list[str]:
        """What stands for each place of the parameter vector; nothing but zero for what the model does not have."""
        c = self.damper.catalogue
        members = {c.column(s.effect.name, s.param.name): s.member for s in self.slots}
        return [f"{{p}}->{members[i]}" if i in members else "0.0" for i in range(c.size)]


def _told(slot: Slot) -> str:
    """What is said of a parameter."""
    return f"[{slot.unit}] {slot.param.meaning}; {slot.low:.6g} to {slot.high:.6g}"


def _line(text: str) -> str:
    """A text within a comment of C."""
    return " ".join(text.split()).replace("*/", "* /")


def write_c(model: Model, folder: Path) -> tuple[Path, ...]:
    """Write header and source of a model's damper into a folder; returns their places.

    Raises:
        InputError: a place that cannot be written.
        Untranslatable: a hook uses what has no form in C.
    """
    files = CCode(model).files
    if folder.exists() and not folder.is_dir():
        raise InputError(folder, "", "a folder", "a file")
    for name, text in files.items():
        write_whole(folder / name, text)
    return tuple(folder / name for name in files)

"""Expressions in C and their types, and where a function that is written in C comes from."""

from __future__ import annotations

import ast
import inspect
import math
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np

from er_models.errors import ErError

Kind = str | tuple[str, ...]
"""Type of a value: double, int, void, or a tuple of them; params and states for the two arrays that stay arrays."""
MATH = (
    "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "ceil", "copysign", "cos", "cosh", "erf",
    "erfc", "exp", "exp2", "expm1", "fabs", "floor", "fmod", "hypot", "log", "log10", "log1p", "log2", "pow", "sin",
    "sinh", "sqrt", "tan", "tanh", "trunc",
)  # fmt: skip
"""Functions of `math` and NumPy that C knows by the same name."""
KEYWORDS = frozenset((
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum", "extern",
    "float", "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return", "short", "signed",
    "sizeof", "static", "struct", "switch", "typedef", "union", "unsigned", "void", "volatile", "while", "greater",
    "lesser", "modulo", "quotient",
)).union(MATH)  # fmt: skip
"""Words that no variable may be called in C."""
ATOM, UNARY, TIMES, PLUS, COMPARED, AND, OR, CHOICE = range(8, 0, -1)
"""How tightly an expression binds in C."""


class Untranslatable(ErError):
    """A function that uses what this translation has no form for in C."""


class Value(NamedTuple):
    """An expression in C, its type, how tightly it binds, and its value where that is known."""

    text: str
    kind: Kind
    level: int = ATOM
    known: Any = None

    def within(self, level: int) -> str:
        """The expression as an operand of one that binds so tightly."""
        return self.text if self.level >= level else f"({self.text})"


@dataclass(frozen=True, eq=False)
class Source:
    """A function to translate: where it stands, its syntax tree, what its names mean outside of it, its name in C."""

    place: str
    tree: ast.FunctionDef
    names: Mapping[str, Any]
    called: str


def source_of(function: Any, called: str) -> Source:
    """A plain Python function, or one that Numba has compiled."""
    plain = getattr(function, "py_func", function)
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(plain))).body[0]
    except (OSError, SyntaxError, TypeError):
        tree = None
    if not isinstance(tree, ast.FunctionDef) or not isinstance(plain, FunctionType):
        raise Untranslatable(
            f"{called}: expected a function with `def` for C code, found {plain!r}"
        )
    known = inspect.getclosurevars(plain)
    place = f"{plain.__code__.co_filename}:{plain.__code__.co_firstlineno}, {plain.__name__}"
    return Source(place, tree, {**plain.__globals__, **known.nonlocals}, called)


def number(value: float) -> Value:
    """A known number."""
    if isinstance(value, bool | np.bool_ | int | np.integer):
        return Value(str(int(value)), "int", ATOM if value >= 0 else UNARY, int(value))
    value = float(value)
    text = {math.inf: "INFINITY", -math.inf: "-INFINITY"}.get(value) or (
        "NAN" if value != value else repr(value)
    )
    return Value(text, "double", UNARY if text.startswith("-") else ATOM, value)


def variable(name: str) -> str:
    """Name of a variable in C."""
    return f"{name}_" if name in KEYWORDS else name


def struct(kind: tuple[str, ...]) -> str:
    """Name of the type of a tuple."""
    return "tuple_" + "".join(part[0] for part in kind)


def wider(one: Kind | None, other: Kind) -> Kind:
    """The type that holds both."""
    if one is None or one == other:
        return other
    if isinstance(one, tuple) and isinstance(other, tuple) and len(one) == len(other):
        return tuple(str(wider(a, b)) for a, b in zip(one, other, strict=True))
    if {one, other} == {"int", "double"}:
        return "double"
    raise Untranslatable(f"a value of the types {one} and {other}")

"""Writes expressions of Python in C; what is known of their values is computed here and now."""

from __future__ import annotations

import ast
import builtins
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import BuiltinFunctionType, FunctionType, ModuleType
from typing import Any

import numpy as np

from er_models.export.values import (
    AND,
    ATOM,
    CHOICE,
    COMPARED,
    MATH,
    OR,
    PLUS,
    TIMES,
    UNARY,
    Kind,
    Source,
    Untranslatable,
    Value,
    number,
    source_of,
    struct,
    variable,
    wider,
)  # fmt: skip

ARITHMETIC: dict[type[ast.operator], tuple[str, int, Callable[[Any, Any], Any]]] = {
    ast.Add: ("+", PLUS, operator.add), ast.Sub: ("-", PLUS, operator.sub), ast.Mult: ("*", TIMES, operator.mul),
    ast.Div: ("/", TIMES, operator.truediv),
}  # fmt: skip
_COMPARISONS: dict[type[ast.cmpop], tuple[str, Callable[[Any, Any], Any]]] = {
    ast.Lt: ("<", operator.lt), ast.LtE: ("<=", operator.le), ast.Gt: (">", operator.gt),
    ast.GtE: (">=", operator.ge), ast.Eq: ("==", operator.eq), ast.NotEq: ("!=", operator.ne),
}  # fmt: skip


@dataclass
class Tables:
    """What functions of one C file share.

    columns: what stands for each place of the parameter vector; shape: rows and columns of the states; tuples, tables:
    types and constant arrays that are used.
    """

    columns: Sequence[str]
    shape: tuple[int, int]
    tuples: dict[str, Kind] = field(default_factory=dict)
    tables: dict[str, Sequence[int]] = field(default_factory=dict)

    def table(self, name: str, values: np.ndarray) -> str:
        """Name of a constant array."""
        self.tables[name.upper()] = values.tolist()
        return name.upper()

    def tuple_type(self, kind: tuple[str, ...]) -> str:
        """Name of a tuple's type."""
        self.tuples[struct(kind)] = kind
        return struct(kind)


class Expressions:
    """Expressions of one function.

    bound: names whose values are known; kinds: types of the others; call: writes the call of a function.
    """

    def __init__(
        self, tables: Tables, source: Source, call: Callable[[Source, Sequence[Value]], Value],
        bound: Mapping[str, Value], kinds: Mapping[str, Kind],
    ) -> None:  # fmt: skip
        self.program, self.source, self.call = tables, source, call
        self.bound, self.kinds = dict(bound), dict(kinds)

    def no(self, node: ast.AST, what: str = "") -> Untranslatable:
        """What is said of something that has no form in C."""
        found = what or f"`{ast.unparse(node)}`"
        return Untranslatable(
            f"{self.source.place}: {found} has no form in C code (numbers, tuples, if, for over a range, while and "
            "functions of math have)"
        )

    def value(self, node: ast.expr) -> Value:
        """One expression."""
        writers: dict[type[ast.expr], Callable[[Any], Value]] = {
            ast.Constant: self._constant, ast.Name: self._name, ast.Attribute: self._attribute,
            ast.UnaryOp: self._unary, ast.BinOp: self._binary, ast.Compare: self._compare,
            ast.BoolOp: self._logic, ast.IfExp: self._choice,
            ast.Call: self._call, ast.Subscript: self._subscript, ast.Tuple: self._tuple,
        }  # fmt: skip
        if type(node) not in writers:
            raise self.no(node)
        return writers[type(node)](node)

    def _constant(self, node: ast.Constant) -> Value:
        if not isinstance(node.value, bool | int | float):
            raise self.no(node)
        return number(node.value)

    def _name(self, node: ast.Name) -> Value:
        name = node.id
        if name in self.bound:
            return self.bound[name]
        if name in self.kinds:
            return Value(variable(name), self.kinds[name])
        found = self.source.names.get(name)
        if isinstance(found, bool | int | float | np.number):
            return number(found)  # type: ignore[arg-type]
        raise self.no(node, f"the name `{name}`")

    def _attribute(self, node: ast.Attribute) -> Value:
        if node.attr == "shape":
            base = self.value(node.value)
            return Value(
                "",
                "shape",
                known=self.program.shape if base.kind == "states" else base.known.shape,
            )
        found = self._module_member(node)
        if isinstance(found, int | float):
            return number(found)
        raise self.no(node)

    def _module_member(self, node: ast.Attribute) -> Any:
        """What an attribute of a module is; None else."""
        module = self.source.names.get(node.value.id) if isinstance(node.value, ast.Name) else None
        return getattr(module, node.attr, None) if isinstance(module, ModuleType) else None

    def _unary(self, node: ast.UnaryOp) -> Value:
        value = self.value(node.operand)
        if isinstance(node.op, ast.Not):
            return (
                number(not value.known)
                if value.known is not None
                else Value(f"!{value.within(ATOM)}", "int", UNARY)
            )
        if isinstance(node.op, ast.USub):
            return (
                number(-value.known)
                if value.known is not None
                else Value(f"-{value.within(ATOM)}", value.kind, UNARY)
            )
        raise self.no(node)

    def _binary(self, node: ast.BinOp) -> Value:
        left, right = self.value(node.left), self.value(node.right)
        both = str(wider(left.kind, right.kind))
        if isinstance(node.op, ast.Pow):
            return Value(f"pow({left.text}, {right.text})", "double")
        if isinstance(node.op, ast.Mod):
            if both == "int":
                return Value(f"{left.within(TIMES)} % {right.within(UNARY)}", "int", TIMES)
            return Value(f"modulo({left.text}, {right.text})", "double")
        if isinstance(node.op, ast.FloorDiv) and both == "double":
            return Value(f"quotient({left.text}, {right.text})", "double")
        if type(node.op) not in ARITHMETIC:
            raise self.no(node)
        sign, level, act = ARITHMETIC[type(node.op)]
        if left.known is not None and right.known is not None and (sign != "/" or right.known):
            return number(act(left.known, right.known))
        cast = "(double)" if sign == "/" and both == "int" else ""
        kind = "double" if sign == "/" else both
        return Value(f"{cast}{left.within(level)} {sign} {right.within(level + 1)}", kind, level)

    def _compare(self, node: ast.Compare) -> Value:
        terms = [self.value(n) for n in (node.left, *node.comparators)]
        if not {*map(type, node.ops)} <= _COMPARISONS.keys():
            raise self.no(node)
        signs = [_COMPARISONS[type(op)] for op in node.ops]
        parts = [
            number(act(a.known, b.known))
            if a.known is not None and b.known is not None
            else Value(f"{a.within(PLUS)} {sign} {b.within(PLUS)}", "int", COMPARED)
            for (sign, act), a, b in zip(signs, terms, terms[1:], strict=False)
        ]
        return self._all(parts, "&&", AND)

    def _logic(self, node: ast.BoolOp) -> Value:
        sign, level = ("&&", AND) if isinstance(node.op, ast.And) else ("||", OR)
        parts = list[Value]()
        for each in node.values:
            parts.append(self.value(each))
            if parts[-1].kind != "int":
                raise self.no(node)
            if parts[-1].known is not None and bool(parts[-1].known) == (sign == "||"):
                break  # what follows is never asked
        return self._all(parts, sign, level)

    @staticmethod
    def _all(parts: Sequence[Value], sign: str, level: int) -> Value:
        """Conditions that all hold, or one of which does, without those that are known."""
        decides = sign == "||"
        left = [p for p in parts if p.known is None]
        if any(p.known is not None and bool(p.known) == decides for p in parts):
            return number(decides)
        if not left:
            return number(not decides)
        return (
            left[0]
            if len(left) == 1
            else Value(f" {sign} ".join(p.within(COMPARED) for p in left), "int", level)
        )

    def _choice(self, node: ast.IfExp) -> Value:
        test = self.value(node.test)
        if test.known is not None:
            return self.value(node.body if test.known else node.orelse)
        yes, no = self.value(node.body), self.value(node.orelse)
        text = f"{test.within(OR)} ? {yes.within(OR)} : {no.within(CHOICE)}"
        return Value(text, wider(yes.kind, no.kind), CHOICE)

    def _tuple(self, node: ast.Tuple) -> Value:
        parts = [self.value(n) for n in node.elts]
        if any(isinstance(part.kind, tuple) for part in parts):
            raise self.no(node)
        kind = tuple(str(part.kind) for part in parts)
        return Value(
            f"({self.program.tuple_type(kind)}){{{', '.join(part.text for part in parts)}}}", kind
        )

    def _subscript(self, node: ast.Subscript) -> Value:
        base = self.value(node.value)
        if base.kind == "states" and isinstance(node.slice, ast.Tuple):
            row, column = node.slice.elts
            named = (
                row.id
                if isinstance(row, ast.Name) and row.id not in self.kinds
                else self.value(row).text
            )
            return Value(f"{base.text}[{named}][{self.value(column).text}]", "double")
        index = self.value(node.slice)
        if base.kind == "params" and isinstance(index.known, int):
            text = self.program.columns[index.known].format(p=base.text)
            return number(float(text)) if text == "0.0" else Value(text, "double")
        if isinstance(base.kind, tuple) and isinstance(index.known, int):
            return Value(f"{base.text}.v{index.known}", base.kind[index.known])
        if base.kind == "shape" or (
            isinstance(base.known, np.ndarray) and index.known is not None
        ):
            return number(base.known[index.known])
        if isinstance(base.known, np.ndarray) and isinstance(node.value, ast.Name):
            return Value(f"{self.program.table(node.value.id, base.known)}[{index.text}]", "int")
        raise self.no(node)

    def _call(self, node: ast.Call) -> Value:
        if node.keywords:
            raise self.no(node)
        function, name = self._called(node)
        given = [self.value(a) for a in node.args]
        if isinstance(function, Source):
            return self.call(function, given)
        if name in ("min", "max") and len(given) > 1:
            return self._extreme("lesser" if name == "min" else "greater", given)
        if name == "float":
            return Value(given[0].text, "double", given[0].level, given[0].known)
        if name in ("int", "bool"):
            return Value(f"({'int' if name == 'int' else '0 != '})({given[0].text})", "int", UNARY)
        text = ", ".join(v.text for v in given)
        return Value(f"{'fabs' if name == 'abs' else name}({text})", "double")

    @staticmethod
    def _extreme(name: str, given: Sequence[Value]) -> Value:
        """The least or largest of several."""
        first, *others = given
        for other in others:
            first = Value(f"{name}({first.text}, {other.text})", "double")
        return first

    def _called(self, node: ast.Call) -> tuple[Source | None, str]:
        """The function that is called: one to translate, or the name of one that C has."""
        if isinstance(node.func, ast.Attribute):
            found, name = self._module_member(node.func), node.func.attr
        elif isinstance(node.func, ast.Name):
            name = node.func.id
            found = self.source.names.get(name, getattr(builtins, name, None))
        else:
            raise self.no(node)
        if isinstance(found, Source):
            return found, name
        plain = getattr(found, "py_func", found)
        if isinstance(plain, FunctionType):
            return source_of(
                plain, f"{plain.__module__.rpartition('.')[2]}__{plain.__name__}"
            ), name
        own = getattr(found, "__name__", name)
        if found in (abs, min, max, float, int, bool) or (
            isinstance(found, BuiltinFunctionType | np.ufunc) and own in MATH
        ):
            return None, own
        if found in (np.abs, np.absolute):
            return None, "abs"
        raise self.no(node.func, f"the function `{ast.unparse(node.func)}`")

"""Writes the functions of the composed kernel, and hooks that it calls, in C99.

What is translated is a small part of Python: numbers, tuples, `if`, `for` over a range, `while`, and functions of
`math`. Everything that is known of a model while its code is written (masks, states in use) is put in, and what it
rules out is left away, so that the C code holds the effects of the model alone.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from er_models.export.expressions import ARITHMETIC, Expressions, Tables
from er_models.export.values import (
    COMPARED,
    Kind,
    Source,
    Untranslatable,
    Value,
    number,
    struct,
    variable,
    wider,
)

_WORD = re.compile(r"(?<!\.)\b[A-Za-z_]\w*")
_GIVEN = re.compile(r"    (?:double|int) (\w+) = [^(]*;$")
"""A variable that is given a value without a call."""


@dataclass
class Program(Tables):
    """C functions in the order in which they need one another."""

    functions: list[str] = field(default_factory=list)
    done: dict[str, tuple[tuple[Kind, ...], Kind]] = field(default_factory=dict)
    """By name in C: types of the arguments, and of the result."""

    def call(self, source: Source, given: Sequence[Value]) -> Value:
        """A call of a function, which is translated when it is first called."""
        passed = [v for v in given if not isinstance(v.known, np.ndarray)]
        if source.called not in self.done:
            self.done[source.called] = ((), "recursive")
            text, result = Function(self, source, given).written()
            self.functions.append(text)
            self.done[source.called] = (tuple(v.kind for v in passed), result)
        kinds, result = self.done[source.called]
        if result == "recursive" or any(
            k == "int" != v.kind for k, v in zip(kinds, passed, strict=False)
        ):
            raise Untranslatable(
                f"{source.place}: recursion, or arguments of changing types, have no form in C"
            )
        return Value(f"{source.called}({', '.join(v.text for v in passed)})", result)


class Function(Expressions):
    """One function on its way to C; its body is gone through until the types of all variables are known."""

    def __init__(self, program: Program, source: Source, given: Sequence[Value]) -> None:
        names = [a.arg for a in source.tree.args.args]
        pairs = list(zip(names, given, strict=False))
        known = {n: v for n, v in pairs if isinstance(v.known, np.ndarray)}
        self.parameters = {n: v.kind for n, v in pairs if n not in known}
        super().__init__(program, source, program.call, known, self.parameters)
        if len(names) != len(given):
            raise self.no(source.tree, "a call with other arguments")
        stored = [
            n.id
            for n in ast.walk(source.tree)
            if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)
        ]
        self.once = {name for name in stored if stored.count(name) == 1} - set(names)
        self.result: Kind | None = None
        self.early: set[str] = set()
        self.lines: list[str] = []

    def written(self) -> tuple[str, Kind]:
        """The function in C, and the type of its result."""
        before: Any = None
        while before != (self.kinds, self.result, self.early):
            before = (dict(self.kinds), self.result, set(self.early))
            self.lines, self.depth, self.temporary = [], 0, 0
            self.declared = set(self.parameters)
            self.block(self.source.tree.body)
        self._without_unread()
        result = self.result or "void"
        arguments = [self._parameter(name, kind) for name, kind in self.parameters.items()]
        head = (
            f"static {self._typed(result)} {self.source.called}({', '.join(arguments) or 'void'})"
        )
        said = (ast.get_docstring(self.source.tree) or "").split("\n\n")[0].replace("*/", "* /")
        about = [f"/* {' '.join(said.split())} */"] if said else []
        first = [f"    {self._typed(self.kinds[n])} {variable(n)};" for n in sorted(self.early)]
        return "\n".join([*about, head, "{", *first, *self.lines, "}"]), result

    def _without_unread(self) -> None:
        """Leave away variables that are given a value without a call and never read."""
        count = -1
        while count != len(self.lines):
            count, words = len(self.lines), Counter(_WORD.findall("\n".join(self.lines)))
            self.lines = [
                s for s in self.lines if not ((m := _GIVEN.match(s)) and words[m[1]] == 1)
            ]

    def _parameter(self, name: str, kind: Kind) -> str:
        """An argument with its type."""
        special = {
            "params": f"const PARAMETERS *{name}",
            "states": f"double {name}[][{self.program.shape[1]}]",
        }
        return special.get(str(kind)) or f"{self._typed(kind)} {variable(name)}"

    def _typed(self, kind: Kind) -> str:
        return self.program.tuple_type(kind) if isinstance(kind, tuple) else kind

    def block(self, statements: Sequence[ast.stmt]) -> None:
        """Statements one after the other; what follows an end that is sure is left away."""
        for node in statements:
            self.statement(node)
            if isinstance(node, ast.Return | ast.Break | ast.Continue):
                return

    @contextmanager
    def inside(self, head: str) -> Iterator[None]:
        """Statements within braces."""
        self.say(f"{head} {{")
        self.depth += 1
        yield
        self.depth -= 1
        self.say("}")

    def say(self, line: str) -> None:
        """A line of C."""
        self.lines.append("    " * (self.depth + 1) + line)

    def statement(self, node: ast.stmt) -> None:
        """One statement."""
        if (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)) or isinstance(
            node, ast.Pass
        ):
            return
        writers: dict[type[ast.stmt], Callable[[Any], None]] = {
            ast.Assign: self._assign, ast.AnnAssign: self._annotated, ast.AugAssign: self._augmented, ast.If: self._if,
            ast.For: self._for, ast.While: self._while, ast.Return: self._return,
            ast.Break: lambda _: self.say("break;"), ast.Continue: lambda _: self.say("continue;"),
            ast.Expr: lambda n: self.say(f"{self.value(n.value).text};"),
        }  # fmt: skip
        if type(node) not in writers:
            raise self.no(node)
        writers[type(node)](node)

    def _assign(self, node: ast.Assign) -> None:
        for target in node.targets:
            self._to(target, node.value)

    def _annotated(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self._to(node.target, node.value)

    def _augmented(self, node: ast.AugAssign) -> None:
        read = ast.parse(ast.unparse(node.target), mode="eval").body
        whole = self.value(ast.BinOp(read, node.op, node.value))
        if type(node.op) in ARITHMETIC and whole.kind == self.value(read).kind:
            self.say(
                f"{self.value(read).text} {ARITHMETIC[type(node.op)][0]}= {self.value(node.value).text};"
            )
        else:
            self._set(node.target, whole)

    def _to(self, target: ast.expr, value: ast.expr) -> None:
        """Give a value to a variable, a place of an array, or several."""
        if isinstance(value, ast.IfExp) and self._is_tuple(value):
            self._either(value, lambda part: self._to(target, part))
        elif isinstance(target, ast.Tuple):
            self._unpack(target.elts, value)
        else:
            self._set(target, self.value(value))

    def _unpack(self, targets: Sequence[ast.expr], value: ast.expr) -> None:
        """Give the parts of a tuple to variables, all of which are read before any is set."""
        if isinstance(value, ast.Tuple):
            parts = [self.value(part) for part in value.elts]
            names = [{n.id for n in ast.walk(t) if isinstance(n, ast.Name)} for t in targets]
            read = [
                {n.id for n in ast.walk(part) if isinstance(n, ast.Name)} for part in value.elts
            ]
            if any(names[i] & read[j] for j in range(len(parts)) for i in range(j)):
                parts = [self._kept(part) for part in parts]
        else:
            whole = self._kept(self.value(value))
            if not isinstance(whole.kind, tuple):
                raise self.no(value)
            parts = [Value(f"{whole.text}.v{i}", kind) for i, kind in enumerate(whole.kind)]
        if len(parts) != len(targets):
            raise self.no(value)
        for target, part in zip(targets, parts, strict=True):
            self._set(target, part)

    def _kept(self, value: Value) -> Value:
        """A value in a variable of its own."""
        self.temporary += 1
        self.say(f"const {self._typed(value.kind)} kept_{self.temporary} = {value.text};")
        return Value(f"kept_{self.temporary}", value.kind)

    def _set(self, target: ast.expr, value: Value) -> None:
        """Give a value to one variable or place."""
        if isinstance(target, ast.Subscript):
            self.say(f"{self.value(target).text} = {value.text};")
            return
        if not isinstance(target, ast.Name):
            raise self.no(target)
        name = target.id
        if name == "_":
            return
        if name in self.once and isinstance(value.known, int):
            self.bound[name] = value
            return
        self.kinds[name] = wider(self.kinds.get(name), value.kind)
        known = name in self.declared or name in self.early
        if not known and self.depth:
            self.early.add(name)
        fresh = not known and not self.depth
        self.declared.add(name)
        kind = f"{self._typed(self.kinds[name])} " if fresh else ""
        self.say(f"{kind}{variable(name)} = {value.text};")

    def _is_tuple(self, node: ast.expr) -> bool:
        """Whether a choice is between tuples."""
        return isinstance(node, ast.Tuple) or (
            isinstance(node, ast.IfExp)
            and (self._is_tuple(node.body) or self._is_tuple(node.orelse))
        )

    def _either(self, node: ast.IfExp | ast.If, use: Callable[[Any], None]) -> None:
        """One of two ways; only one of them where the condition is known."""
        test = self.value(node.test)
        if test.known is not None:
            use(node.body if test.known else node.orelse)
            return
        with self.inside(f"if ({test.text})"):
            use(node.body)
        if node.orelse:
            with self.inside("else"):
                use(node.orelse)

    def _if(self, node: ast.If) -> None:
        self._either(node, self.block)

    def _for(self, node: ast.For) -> None:
        call = node.iter
        good = (
            isinstance(call, ast.Call)
            and isinstance(call.func, ast.Name)
            and call.func.id == "range"
        )
        if not good or not isinstance(node.target, ast.Name) or node.orelse or len(call.args) > 2:  # type: ignore[attr-defined]
            raise self.no(node, "a loop over anything but a range")
        ends = [self.value(a) for a in call.args]  # type: ignore[attr-defined]
        low, high = [number(0), *ends] if len(ends) == 1 else ends
        if low.known is not None and high.known is not None and high.known <= low.known:
            return
        name = variable(node.target.id)
        self.kinds[node.target.id] = "int"
        with self.inside(
            f"for (int {name} = {low.text}; {name} < {high.within(COMPARED)}; {name}++)"
        ):
            self.block(node.body)

    def _while(self, node: ast.While) -> None:
        with self.inside(f"while ({self.value(node.test).text})"):
            self.block(node.body)

    def _return(self, node: ast.Return) -> None:
        if node.value is None:
            self.say("return;")
        elif isinstance(node.value, ast.IfExp) and self._is_tuple(node.value):
            self._either(node.value, lambda part: self._return(ast.Return(part)))
        else:
            value = self.value(node.value)
            self.result = wider(self.result, value.kind)
            text = value.text
            if isinstance(self.result, tuple) and isinstance(node.value, ast.Tuple):
                text = text.replace(struct(value.kind), self._typed(self.result), 1)  # type: ignore[arg-type]
            self.say(f"return {text};")

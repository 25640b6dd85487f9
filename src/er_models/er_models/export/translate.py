"""Writes the functions of the composed kernel, and hooks that it calls, in C99.

What is translated is a small part of Python: numbers, tuples, `if`, `for` over a range, `while`, and functions of `math`.
Everything that is known of a model while its code is written (masks, states in use) is put in, and what it rules out is left
away, so that the C code holds the effects of the model alone.
"""

from __future__ import annotations

import ast
import builtins
import inspect
import math
import operator
import re
import textwrap
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from types import BuiltinFunctionType, FunctionType, ModuleType
from typing import Any, NamedTuple

import numpy as np

from er_models.errors import ErError

Kind = str | tuple[str, ...]
"""Type of a value: double, int, void, or a tuple of them; params and states for the two arrays that stay arrays."""
MATH = (
    "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "ceil", "copysign", "cos", "cosh", "erf", "erfc",
    "exp", "exp2", "expm1", "fabs", "floor", "fmod", "hypot", "log", "log10", "log1p", "log2", "pow", "sin", "sinh",
    "sqrt", "tan", "tanh", "trunc",
)  # fmt: skip
"""Functions of `math` and NumPy that C knows by the same name."""
KEYWORDS = frozenset(
    "auto break case char const continue default do double else enum extern float for goto if inline int long "
    "register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while "
    "greater lesser modulo".split()
).union(MATH)
"""Words that no variable may be called in C."""
ATOM, UNARY, TIMES, PLUS, COMPARED, AND, OR, CHOICE = range(8, 0, -1)
"""How tightly an expression binds in C."""
_ARITHMETIC: dict[type[ast.operator], tuple[str, int, Callable[[Any, Any], Any]]] = {
    ast.Add: ("+", PLUS, operator.add), ast.Sub: ("-", PLUS, operator.sub), ast.Mult: ("*", TIMES, operator.mul),
    ast.Div: ("/", TIMES, operator.truediv),
}  # fmt: skip
_COMPARISONS: dict[type[ast.cmpop], tuple[str, Callable[[Any, Any], Any]]] = {
    ast.Lt: ("<", operator.lt), ast.LtE: ("<=", operator.le), ast.Gt: (">", operator.gt),
    ast.GtE: (">=", operator.ge), ast.Eq: ("==", operator.eq), ast.NotEq: ("!=", operator.ne),
}  # fmt: skip
_WORD = re.compile(r"(?<!\.)\b[A-Za-z_]\w*")
_GIVEN = re.compile(r"    (?:double|int) (\w+) = [^(]*;$")
"""A variable that is given a value without a call."""


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
        raise Untranslatable(f"{called}: expected a function with `def` for C code, found {plain!r}")
    known = inspect.getclosurevars(plain)
    place = f"{plain.__code__.co_filename}:{plain.__code__.co_firstlineno}, {plain.__name__}"
    return Source(place, tree, {**plain.__globals__, **known.nonlocals}, called)


def number(value: float) -> Value:
    """A known number."""
    if isinstance(value, bool | np.bool_ | int | np.integer):
        return Value(str(int(value)), "int", ATOM if value >= 0 else UNARY, int(value))
    value = float(value)
    text = {math.inf: "INFINITY", -math.inf: "-INFINITY"}.get(value) or ("NAN" if value != value else repr(value))
    return Value(text, "double", UNARY if text.startswith("-") else ATOM, value)


def variable(name: str) -> str:
    """Name of a variable in C."""
    return f"{name}_" if name in KEYWORDS else name


def struct(kind: tuple[str, ...]) -> str:
    """Name of the type of a tuple."""
    return "tuple_" + "".join(part[0] for part in kind)


def typed(kind: Kind) -> str:
    """A type in C."""
    return struct(kind) if isinstance(kind, tuple) else kind


def wider(one: Kind | None, other: Kind) -> Kind:
    """The type that holds both."""
    if one is None or one == other:
        return other
    if isinstance(one, tuple) and isinstance(other, tuple) and len(one) == len(other):
        return tuple(str(wider(a, b)) for a, b in zip(one, other, strict=True))
    if {one, other} == {"int", "double"}:
        return "double"
    raise Untranslatable(f"a value of the types {one} and {other}")


@dataclass
class Program:
    """C functions in the order in which they need one another.

    columns: what stands for each place of the parameter vector; shape: rows and columns of the states; tuples, tables:
    types and constant arrays that the functions use.
    """

    columns: Sequence[str]
    shape: tuple[int, int]
    functions: list[str] = field(default_factory=list)
    tuples: dict[str, Kind] = field(default_factory=dict)
    tables: dict[str, Sequence[int]] = field(default_factory=dict)
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
        if result == "recursive" or any(k == "int" != v.kind for k, v in zip(kinds, passed, strict=False)):
            raise Untranslatable(f"{source.place}: recursion, or arguments of changing types, have no form in C")
        return Value(f"{source.called}({', '.join(v.text for v in passed)})", result)

    def table(self, name: str, values: np.ndarray) -> str:
        """Name of a constant array."""
        self.tables[name.upper()] = values.tolist()
        return name.upper()

    def tuple_type(self, kind: tuple[str, ...]) -> str:
        """Name of a tuple's type."""
        self.tuples[struct(kind)] = kind
        return struct(kind)


class Function:
    """One function on its way to C; its body is gone through until the types of all variables are known."""

    def __init__(self, program: Program, source: Source, given: Sequence[Value]) -> None:
        self.program, self.source = program, source
        names = [a.arg for a in source.tree.args.args]
        if len(names) != len(given):
            raise self._no(source.tree, "a call with other arguments")
        self.bound = {n: v for n, v in zip(names, given, strict=True) if isinstance(v.known, np.ndarray)}
        self.parameters = {
            n: v.kind for n, v in zip(names, given, strict=True) if not isinstance(v.known, np.ndarray)
        }
        stored = [n.id for n in ast.walk(source.tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]
        self.once = {name for name in stored if stored.count(name) == 1} - set(names)
        self.kinds: dict[str, Kind] = dict(self.parameters)
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
        head = f"static {self._typed(result)} {self.source.called}({', '.join(arguments) or 'void'})"
        said = (ast.get_docstring(self.source.tree) or "").split("\n\n")[0].replace("*/", "* /")
        about = [f"/* {' '.join(said.split())} */"] if said else []
        first = [f"    {self._typed(self.kinds[n])} {variable(n)};" for n in sorted(self.early)]
        return "\n".join([*about, head, "{", *first, *self.lines, "}"]), result

    def _without_unread(self) -> None:
        """Leave away variables that are given a value without a call and never read."""
        count = -1
        while count != len(self.lines):
            count, words = len(self.lines), Counter(_WORD.findall("\n".join(self.lines)))
            self.lines = [s for s in self.lines if not ((m := _GIVEN.match(s)) and words[m[1]] == 1)]

    def _parameter(self, name: str, kind: Kind) -> str:
        """An argument with its type."""
        special = {"params": f"const PARAMETERS *{name}", "states": f"double {name}[][{self.program.shape[1]}]"}
        return special.get(str(kind)) or f"{self._typed(kind)} {variable(name)}"

    def _typed(self, kind: Kind) -> str:
        return self.program.tuple_type(kind) if isinstance(kind, tuple) else kind

    def _no(self, node: ast.AST, what: str = "") -> Untranslatable:
        """What is said of something that has no form in C."""
        found = what or f"`{ast.unparse(node)}`"
        return Untranslatable(
            f"{self.source.place}: {found} has no form in C code (numbers, tuples, if, for over a range, while and "
            "functions of math have)"
        )

    # statements

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
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) or isinstance(node, ast.Pass):
            return
        writers: dict[type[ast.stmt], Callable[[Any], None]] = {
            ast.Assign: self._assign, ast.AnnAssign: self._annotated, ast.AugAssign: self._augmented, ast.If: self._if,
            ast.For: self._for, ast.While: self._while, ast.Return: self._return, ast.Break: lambda _: self.say("break;"),
            ast.Continue: lambda _: self.say("continue;"), ast.Expr: lambda n: self.say(f"{self.value(n.value).text};"),
        }  # fmt: skip
        if type(node) not in writers:
            raise self._no(node)
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
        if type(node.op) in _ARITHMETIC and whole.kind == self.value(read).kind:
            self.say(f"{self.value(read).text} {_ARITHMETIC[type(node.op)][0]}= {self.value(node.value).text};")
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
            read = [{n.id for n in ast.walk(part) if isinstance(n, ast.Name)} for part in value.elts]
            if any(names[i] & read[j] for j in range(len(parts)) for i in range(j)):
                parts = [self._kept(part) for part in parts]
        else:
            whole = self._kept(self.value(value))
            if not isinstance(whole.kind, tuple):
                raise self._no(value)
            parts = [Value(f"{whole.text}.v{i}", kind) for i, kind in enumerate(whole.kind)]
        if len(parts) != len(targets):
            raise self._no(value)
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
            raise self._no(target)
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
            isinstance(node, ast.IfExp) and (self._is_tuple(node.body) or self._is_tuple(node.orelse))
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
        good = isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "range"
        if not good or not isinstance(node.target, ast.Name) or node.orelse or len(call.args) > 2:  # type: ignore[attr-defined]
            raise self._no(node, "a loop over anything but a range")
        ends = [self.value(a) for a in call.args]  # type: ignore[attr-defined]
        low, high = ([number(0), *ends] if len(ends) == 1 else ends)
        if low.known is not None and high.known is not None and high.known <= low.known:
            return
        name = variable(node.target.id)
        self.kinds[node.target.id] = "int"
        with self.inside(f"for (int {name} = {low.text}; {name} < {high.within(COMPARED)}; {name}++)"):
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

    # expressions

    def value(self, node: ast.expr) -> Value:
        """One expression."""
        writers: dict[type[ast.expr], Callable[[Any], Value]] = {
            ast.Constant: self._constant, ast.Name: self._name, ast.Attribute: self._attribute, ast.UnaryOp: self._unary,
            ast.BinOp: self._binary, ast.Compare: self._compare, ast.BoolOp: self._logic, ast.IfExp: self._choice,
            ast.Call: self._call, ast.Subscript: self._subscript, ast.Tuple: self._tuple,
        }  # fmt: skip
        if type(node) not in writers:
            raise self._no(node)
        return writers[type(node)](node)

    def _constant(self, node: ast.Constant) -> Value:
        if not isinstance(node.value, bool | int | float):
            raise self._no(node)
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
        raise self._no(node, f"the name `{name}`")

    def _attribute(self, node: ast.Attribute) -> Value:
        if node.attr == "shape":
            base = self.value(node.value)
            return Value("", "shape", known=self.program.shape if base.kind == "states" else base.known.shape)
        found = self._module_member(node)
        if isinstance(found, int | float):
            return number(found)
        raise self._no(node)

    def _module_member(self, node: ast.Attribute) -> Any:
        """What an attribute of a module is; None else."""
        module = self.source.names.get(node.value.id) if isinstance(node.value, ast.Name) else None
        return getattr(module, node.attr, None) if isinstance(module, ModuleType) else None

    def _unary(self, node: ast.UnaryOp) -> Value:
        value = self.value(node.operand)
        if isinstance(node.op, ast.Not):
            return number(not value.known) if value.known is not None else Value(f"!{value.within(ATOM)}", "int", UNARY)
        if isinstance(node.op, ast.USub):
            return number(-value.known) if value.known is not None else Value(f"-{value.within(ATOM)}", value.kind, UNARY)
        raise self._no(node)

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
            return Value(f"floor({left.within(TIMES)} / {right.within(UNARY)})", "double")
        if type(node.op) not in _ARITHMETIC:
            raise self._no(node)
        sign, level, act = _ARITHMETIC[type(node.op)]
        if left.known is not None and right.known is not None and (sign != "/" or right.known):
            return number(act(left.known, right.known))
        cast = "(double)" if sign == "/" and both == "int" else ""
        kind = "double" if sign == "/" else both
        return Value(f"{cast}{left.within(level)} {sign} {right.within(level + 1)}", kind, level)

    def _compare(self, node: ast.Compare) -> Value:
        terms = [self.value(n) for n in (node.left, *node.comparators)]
        signs = [_COMPARISONS.get(type(op)) for op in node.ops]
        if None in signs:
            raise self._no(node)
        parts = [
            number(act(a.known, b.known))
            if a.known is not None and b.known is not None
            else Value(f"{a.within(PLUS)} {sign} {b.within(PLUS)}", "int", COMPARED)
            for (sign, act), a, b in zip(signs, terms, terms[1:], strict=False)  # type: ignore[misc]
        ]
        return self._all(parts, "&&", AND)

    def _logic(self, node: ast.BoolOp) -> Value:
        sign, level = ("&&", AND) if isinstance(node.op, ast.And) else ("||", OR)
        parts = list[Value]()
        for each in node.values:
            parts.append(self.value(each))
            if parts[-1].kind != "int":
                raise self._no(node)
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
        return left[0] if len(left) == 1 else Value(f" {sign} ".join(p.within(COMPARED) for p in left), "int", level)

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
            raise self._no(node)
        kind = tuple(str(part.kind) for part in parts)
        return Value(f"({self.program.tuple_type(kind)}){{{', '.join(part.text for part in parts)}}}", kind)

    def _subscript(self, node: ast.Subscript) -> Value:
        base = self.value(node.value)
        if base.kind == "states" and isinstance(node.slice, ast.Tuple):
            row, column = node.slice.elts
            named = row.id if isinstance(row, ast.Name) and row.id not in self.kinds else self.value(row).text
            return Value(f"{base.text}[{named}][{self.value(column).text}]", "double")
        index = self.value(node.slice)
        if base.kind == "params" and isinstance(index.known, int):
            text = self.program.columns[index.known].format(p=base.text)
            return number(float(text)) if text == "0.0" else Value(text, "double")
        if isinstance(base.kind, tuple) and isinstance(index.known, int):
            return Value(f"{base.text}.v{index.known}", base.kind[index.known])
        if base.kind == "shape" or (isinstance(base.known, np.ndarray) and index.known is not None):
            return number(base.known[index.known])
        if isinstance(base.known, np.ndarray) and isinstance(node.value, ast.Name):
            return Value(f"{self.program.table(node.value.id, base.known)}[{index.text}]", "int")
        raise self._no(node)

    def _call(self, node: ast.Call) -> Value:
        if node.keywords:
            raise self._no(node)
        function, name = self._called(node)
        given = [self.value(a) for a in node.args]
        if isinstance(function, Source):
            return self.program.call(function, given)
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
            raise self._no(node)
        if isinstance(found, Source):
            return found, name
        plain = getattr(found, "py_func", found)
        if isinstance(plain, FunctionType):
            return source_of(plain, f"{plain.__module__.rpartition('.')[2]}__{plain.__name__}"), name
        own = getattr(found, "__name__", name)
        if found in (abs, min, max, float, int, bool) or (
            isinstance(found, BuiltinFunctionType | np.ufunc) and own in MATH
        ):
            return None, own
        if found in (np.abs, np.absolute):
            return None, "abs"
        raise self._no(node.func, f"the function `{ast.unparse(node.func)}`")

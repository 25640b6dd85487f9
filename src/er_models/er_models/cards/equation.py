"""The equations of an effect, translated from the source of its hooks."""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from er_models.cards.formula import Formula, Latex, Plain, Unwritable
from er_models.cards.mathml import MathMl, left_side, whole
from er_models.cards.symbols import ACTS
from er_models.effect import Effect, arguments


@dataclass(frozen=True, slots=True)
class Equation:
    """What one hook does: its name, meaning, the equation in text, LaTeX and MathML (empty: see source), its source."""

    hook: str
    meaning: str
    plain: str
    latex: str
    mathml: str
    source: str


def equations(effect: Effect) -> tuple[Equation, ...]:
    """One equation for every hook, in the order of the effect."""
    return tuple(_equation(hook, function) for hook, function in effect.hooks.items())


def _equation(hook: str, function: Callable[..., object]) -> Equation:
    """Equation of one hook; only its source where it cannot be written as a formula."""
    source = textwrap.dedent(inspect.getsource(function)).rstrip()
    meaning = (function.__doc__ or "").strip().partition("\n")[0]
    sides = ACTS[hook]
    try:
        value = _value(source, _constants(function))
        texts = [_written(hook, value, formula) for formula in (Plain(), Latex(), MathMl())]
    except Unwritable:
        return Equation(hook, meaning, "", "", "", source)
    written = [f"{side} {text}" for side, text in zip(sides, texts, strict=False)]
    mathml = whole(left_side(sides[0]) + texts[2])
    return Equation(hook, meaning, written[0], written[1], mathml, source)


def _written(hook: str, value: ast.expr, formula: Formula) -> str:
    """Right side of the equation of a hook."""
    if hook != "relax":
        return formula.write(value)
    if isinstance(value, ast.IfExp) and isinstance(value.body, ast.Tuple):
        parts = [_rate(value.body), _rate(value.orelse)]
        return formula.write(ast.IfExp(value.test, parts[0], parts[1]))
    return formula.write(_rate(value))


def _rate(value: ast.expr) -> ast.expr:
    """Drive - rate w, of the pair (rate, drive)."""
    if not isinstance(value, ast.Tuple) or len(value.elts) != 2:
        raise Unwritable(ast.unparse(value))
    rate, drive = value.elts
    state = ast.Name("w")
    product = isinstance(drive, ast.BinOp) and isinstance(drive.op, ast.Mult)
    if isinstance(drive, ast.BinOp) and product and ast.dump(drive.left) == ast.dump(rate):
        return _times(rate, ast.BinOp(drive.right, ast.Sub(), state))
    if isinstance(rate, ast.Constant) and rate.value == 0.0:
        return drive
    decay = _times(rate, state)
    if isinstance(drive, ast.Constant) and drive.value == 0.0:
        return ast.UnaryOp(ast.USub(), decay)
    return ast.BinOp(drive, ast.Sub(), decay)


def _times(rate: ast.expr, other: ast.expr) -> ast.expr:
    """A product, with the numerator of a quotient taking the other factor."""
    if not (isinstance(rate, ast.BinOp) and isinstance(rate.op, ast.Div)):
        return ast.BinOp(rate, ast.Mult(), other)
    top = rate.left
    one = isinstance(top, ast.Constant) and top.value == 1.0
    return ast.BinOp(other if one else ast.BinOp(top, ast.Mult(), other), ast.Div(), rate.right)


def _constants(function: Callable[..., object]) -> dict[str, ast.expr]:
    """Numbers of a hook's module, by name, which a formula shows as such; those of physics keep their symbols."""
    module = getattr(function, "__globals__", {})
    return {
        name: ast.Constant(value)
        for name, value in module.items()
        if name.isupper() and isinstance(value, int | float) and name not in arguments(function)
    }


def _value(source: str, constants: Mapping[str, ast.expr] = {}) -> ast.expr:
    """The value of a function of assignments and one return; locals and constants replaced by what they stand for."""
    tree = ast.parse(source).body[0]
    if not isinstance(tree, ast.FunctionDef):
        raise Unwritable(source)
    known = dict(constants)
    for node in tree.body:
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            continue
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            known[node.targets[0].id] = _Replace(known).visit(node.value)
        elif isinstance(node, ast.Return) and node.value is not None:
            replaced: ast.expr = _Replace(known).visit(node.value)
            return replaced
        else:
            break
    raise Unwritable(source)


class _Replace(ast.NodeTransformer):
    """Puts expressions in the place of names."""

    def __init__(self, known: Mapping[str, ast.expr]) -> None:
        self.known = known

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return self.known.get(node.id, node)

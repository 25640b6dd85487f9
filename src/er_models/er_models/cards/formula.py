"""Writes the expression of a hook as a formula, in plain text and in LaTeX.

The formula is translated from the very source that is compiled: every guard and every case in the code
is in the formula.
"""

from __future__ import annotations

import ast
from collections.abc import Callable

from er_models.cards.symbols import latex, plain

_LEVEL: dict[type[ast.AST], int] = {
    ast.IfExp: 0, ast.BoolOp: 0, ast.Compare: 1, ast.Add: 2, ast.Sub: 2, ast.Mult: 3, ast.Div: 3,
    ast.USub: 3, ast.Pow: 5,
}  # fmt: skip
ATOM = 6
"""How tightly a name or a number binds."""
_COMPARE = {ast.Gt: ">", ast.GtE: ">=", ast.Lt: "<", ast.LtE: "<=", ast.Eq: "=", ast.NotEq: "!="}
_LATEX_COMPARE = {">=": r"\ge", "<=": r"\le", "!=": r"\ne"}


class Unwritable(Exception):
    """An expression that has no form as a formula."""


def level(node: ast.AST) -> int:
    """How tightly an expression binds."""
    if isinstance(node, ast.BinOp):
        return _LEVEL.get(type(node.op), ATOM)
    if isinstance(node, ast.UnaryOp):
        return _LEVEL[ast.USub]
    return _LEVEL.get(type(node), ATOM)


def number(value: object) -> str:
    """A constant as one writes it."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise Unwritable(repr(value))
    if value and not 1e-3 <= abs(value) < 1e6:
        mantissa, exponent = f"{value:.12e}".split("e")
        return f"{mantissa.rstrip('0').rstrip('.')}e{int(exponent)}"
    return f"{value:.15g}"


def factors(node: ast.expr) -> list[tuple[ast.expr, int]]:
    """Factors of a product in their order, equal ones as one with its power."""
    found: list[tuple[ast.expr, int]] = []
    stack = [node]
    while stack:
        top = stack.pop()
        if isinstance(top, ast.BinOp) and isinstance(top.op, ast.Mult):
            stack += [top.right, top.left]
            continue
        same = [i for i, (f, _) in enumerate(found) if ast.dump(f) == ast.dump(top)]
        if same:
            found[same[0]] = (top, found[same[0]][1] + 1)
        else:
            found.append((top, 1))
    return found


class Formula:
    """Translates expressions; subclasses say how each piece is written."""

    def write(self, node: ast.expr) -> str:
        """Formula of an expression; `Unwritable` where there is none."""
        if isinstance(node, ast.Name):
            return self.name(node.id)
        if isinstance(node, ast.Constant):
            return self.number(number(node.value))
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            return self.negative(self.inside(node.operand, 3))
        if isinstance(node, ast.BinOp):
            return self.operation(node)
        if isinstance(node, ast.Call):
            return self.call(node)
        if isinstance(node, ast.IfExp):
            return self.cases(node)
        if isinstance(node, ast.Compare) and len(node.ops) == 1:
            sign = self.comparison(_COMPARE[type(node.ops[0])])
            return f"{self.write(node.left)} {sign} {self.write(node.comparators[0])}"
        if isinstance(node, ast.BoolOp):
            word = self.word(" and " if isinstance(node.op, ast.And) else " or ")
            return word.join(self.write(v) for v in node.values)
        raise Unwritable(ast.unparse(node))

    def inside(self, node: ast.expr, least: int) -> str:
        """An operand, in brackets where it binds less tightly than `least`."""
        text = self.write(node)
        return text if level(node) >= least else self.brackets(text)

    def call(self, node: ast.Call) -> str:
        """A function of `math` or a builtin."""
        if isinstance(node.func, ast.Name):
            name = node.func.id
        elif isinstance(node.func, ast.Attribute):
            name = node.func.attr
        else:
            raise Unwritable(ast.unparse(node))
        if name == "float":
            return self.write(node.args[0])
        if name == "abs":
            return self.absolute(self.write(node.args[0]))
        return self.function(name, [self.write(a) for a in node.args])

    name: Callable[[str], str]

    def number(self, text: str) -> str:
        """A constant."""
        return text

    def brackets(self, text: str) -> str:
        """Brackets."""
        return f"({text})"

    def negative(self, text: str) -> str:
        """A sign."""
        return f"-{text}"

    def absolute(self, text: str) -> str:
        """Bars."""
        return f"|{text}|"

    def word(self, text: str) -> str:
        """A word between formulas."""
        return text

    def comparison(self, sign: str) -> str:
        """A comparison sign."""
        return sign

    def operation(self, node: ast.BinOp) -> str:
        """A sum, product, quotient or power."""
        raise NotImplementedError

    def function(self, name: str, arguments: list[str]) -> str:
        """A named function."""
        return f"{name}({', '.join(arguments)})"

    def cases(self, node: ast.IfExp) -> str:
        """One of several expressions."""
        raise NotImplementedError


class Plain(Formula):
    """Formulas for the terminal."""

    name = staticmethod(plain)

    def operation(self, node: ast.BinOp) -> str:
        """Sums and products with spaces, powers without."""
        if isinstance(node.op, ast.Pow):
            return f"{self.inside(node.left, ATOM)}^{self.inside(node.right, ATOM)}"
        if isinstance(node.op, ast.Mult):
            return " ".join(self.factor(f, n, i) for i, (f, n) in enumerate(factors(node)))
        if isinstance(node.op, ast.Div):
            return f"{self.inside(node.left, 3)} / {self.inside(node.right, 4)}"
        sign = {ast.Add: "+", ast.Sub: "-"}[type(node.op)]
        return f"{self.inside(node.left, 2)} {sign} {self.inside(node.right, 3)}"

    def factor(self, node: ast.expr, power: int, place: int) -> str:
        """A factor of a product, with its power; only the first may carry a sign."""
        if power > 1:
            return f"{self.inside(node, ATOM)}^{power}"
        return self.inside(node, 3 if place == 0 and isinstance(node, ast.UnaryOp) else 4)

    def cases(self, node: ast.IfExp) -> str:
        """``A if condition, else B``."""
        first, test = self.inside(node.body, 1), self.write(node.test)
        return f"{first} if {test}, else {self.inside(node.orelse, 0)}"


class Latex(Formula):
    """Formulas for documents."""

    name = staticmethod(latex)

    def number(self, text: str) -> str:
        """Powers of ten as such."""
        mantissa, _, exponent = text.partition("e")
        if not exponent:
            return text
        factor = "" if mantissa == "1" else rf"{mantissa} \cdot "
        return rf"{factor}10^{{{exponent}}}"

    def brackets(self, text: str) -> str:
        """Brackets that grow."""
        return rf"\left({text}\right)"

    def word(self, text: str) -> str:
        """Upright text."""
        return rf"\text{{{text}}}"

    def comparison(self, sign: str) -> str:
        """A comparison sign."""
        return _LATEX_COMPARE.get(sign, sign)

    def operation(self, node: ast.BinOp) -> str:
        """Quotients as fractions, powers as such."""
        if isinstance(node.op, ast.Pow):
            return f"{self.inside(node.left, ATOM)}^{{{self.write(node.right)}}}"
        if isinstance(node.op, ast.Mult):
            return r" \, ".join(self.factor(f, n) for f, n in factors(node))
        if isinstance(node.op, ast.Div) and isinstance(node.left, ast.UnaryOp):
            return f"-{self.operation(ast.BinOp(node.left.operand, ast.Div(), node.right))}"
        if isinstance(node.op, ast.Div):
            return rf"\frac{{{self.write(node.left)}}}{{{self.write(node.right)}}}"
        sign = {ast.Add: "+", ast.Sub: "-"}[type(node.op)]
        return f"{self.inside(node.left, 2)} {sign} {self.inside(node.right, 3)}"

    def factor(self, node: ast.expr, power: int) -> str:
        """A factor of a product, with its power."""
        if power == 1:
            return self.inside(node, 3)
        return f"{self.inside(node, ATOM)}^{power}"

    def function(self, name: str, arguments: list[str]) -> str:
        """Functions LaTeX knows, the exponential as a power, others upright."""
        if name == "exp":
            return f"e^{{{arguments[0]}}}"
        if name == "sqrt":
            return rf"\sqrt{{{arguments[0]}}}"
        known = name in ("tanh", "sin", "cos", "max", "min", "log")
        head = f"\\{name}" if known else rf"\operatorname{{{name}}}"
        return rf"{head}\left({', '.join(arguments)}\right)"

    def cases(self, node: ast.IfExp) -> str:
        """A brace with one line a case."""
        rows = [f"{self.write(node.body)} & {self.write(node.test)}"]
        rest: ast.expr = node.orelse
        while isinstance(rest, ast.IfExp):
            rows.append(f"{self.write(rest.body)} & {self.write(rest.test)}")
            rest = rest.orelse
        rows.append(rf"{self.write(rest)} & \text{{else}}")
        return r"\begin{cases} " + r" \\ ".join(rows) + r" \end{cases}"

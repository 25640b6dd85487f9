"""Formulas as MathML, which browsers typeset without any script or font."""

from __future__ import annotations

import ast
from html import escape

from er_models.cards.formula import ATOM, Formula, factors
from er_models.cards.symbols import plain

GREEK = {
    "tau": "\u03c4", "sigma": "\u03c3", "beta": "\u03b2", "theta": "\u03b8", "gamma": "\u03b3", "omega": "\u03c9",
}  # fmt: skip
SIGNS = {
    ">=": "\u2265",
    "<=": "\u2264",
    "!=": "\u2260",
    "-": "\u2212",
    "*=": "\u00d7=",
    "-=": "\u2212=",
}
"""Signs of the plain text as they are typeset."""
BAR = '<mo stretchy="true">|</mo>'


def whole(text: str) -> str:
    """A formula of its own."""
    return f'<math display="block">{text}</math>'


def left_side(text: str) -> str:
    """What stands left of an equation, from its plain text: ``F_d +=``, ``w' =``, ``|w| <=``, ``delay of u +=``."""
    *words, sign = text.split()
    if not set(sign) <= set("+:*=<>-"):
        return f"<mtext>{escape(text)}&nbsp;</mtext>"
    return "".join(_word(w) for w in words) + _sign(sign)


def _word(text: str) -> str:
    """A symbol, with its bars or its prime, or a word."""
    bare = text.strip("|'")
    if text.startswith("|"):
        return f"<mrow>{BAR}{symbol(bare)}{BAR}</mrow>"
    if text.endswith("'"):
        return f"<msup>{symbol(bare)}<mo>\u2032</mo></msup>"
    return symbol(text) if text not in ("delay", "of") else f"<mtext>{text}&nbsp;</mtext>"


def _sign(text: str) -> str:
    return f"<mo>{escape(SIGNS.get(text, text))}</mo>"


def symbol(name: str) -> str:
    """A name: a letter, Greek where it is, with what follows as its index."""
    letter, _, index = plain(name).partition("_")
    digits = letter[len(letter.rstrip("0123456789")) :]
    letter, index = (
        letter.removesuffix(digits),
        ",".join(filter(None, (digits, index.replace("_", ",")))),
    )
    base = f"<mi>{GREEK.get(letter, letter)}</mi>"
    return f"<msub>{base}<mi>{GREEK.get(index, index)}</mi></msub>" if index else base


class MathMl(Formula):
    """Formulas for pages: the text of every piece is one element, or several in a row."""

    name = staticmethod(symbol)

    def number(self, text: str) -> str:
        """Powers of ten as such."""
        mantissa, _, exponent = text.partition("e")
        if not exponent:
            return f"<mn>{text}</mn>"
        power = f"<msup><mn>10</mn><mn>{exponent.replace('-', SIGNS['-'])}</mn></msup>"
        return (
            power if mantissa == "1" else f"<mrow><mn>{mantissa}</mn><mo>\u00b7</mo>{power}</mrow>"
        )

    def brackets(self, text: str) -> str:
        """Brackets that grow."""
        return f"<mrow><mo>(</mo>{text}<mo>)</mo></mrow>"

    def negative(self, text: str) -> str:
        """A sign."""
        return f"<mrow>{_sign('-')}{text}</mrow>"

    def absolute(self, text: str) -> str:
        """Bars that grow."""
        return f"<mrow>{BAR}{text}{BAR}</mrow>"

    def word(self, text: str) -> str:
        """Upright text."""
        return f"<mtext>&nbsp;{text.strip()}&nbsp;</mtext>"

    def comparison(self, sign: str) -> str:
        """A comparison sign."""
        return _sign(sign)

    def operation(self, node: ast.BinOp) -> str:
        """Quotients as fractions, powers as such, products without a sign."""
        if isinstance(node.op, ast.Pow):
            return (
                f"<msup>{_row(self.inside(node.left, ATOM))}{_row(self.write(node.right))}</msup>"
            )
        if isinstance(node.op, ast.Mult):
            return '<mspace width="0.17em"/>'.join(self.factor(f, n) for f, n in factors(node))
        if isinstance(node.op, ast.Div) and isinstance(node.left, ast.UnaryOp):
            return self.negative(
                self.operation(ast.BinOp(node.left.operand, ast.Div(), node.right))
            )
        if isinstance(node.op, ast.Div):
            return f"<mfrac>{_row(self.write(node.left))}{_row(self.write(node.right))}</mfrac>"
        sign = _sign({ast.Add: "+", ast.Sub: "-"}[type(node.op)])
        return f"{self.inside(node.left, 2)}{sign}{self.inside(node.right, 3)}"

    def factor(self, node: ast.expr, power: int) -> str:
        """A factor of a product, with its power."""
        if power == 1:
            return self.inside(node, 3)
        return f"<msup>{_row(self.inside(node, ATOM))}<mn>{power}</mn></msup>"

    def function(self, name: str, arguments: list[str]) -> str:
        """The exponential as a power, a root as such, others upright."""
        if name == "exp":
            return f"<msup><mi>e</mi>{_row(arguments[0])}</msup>"
        if name == "sqrt":
            return f"<msqrt>{arguments[0]}</msqrt>"
        return f'<mi mathvariant="normal">{escape(name)}</mi>{self.brackets("<mo>,</mo>".join(arguments))}'

    def cases(self, node: ast.IfExp) -> str:
        """A brace with one line a case."""
        rows: list[str] = []
        rest: ast.expr = node
        while isinstance(rest, ast.IfExp):
            rows.append(_case(self.write(rest.body), f"{self.word('if')}{self.write(rest.test)}"))
            rest = rest.orelse
        rows.append(_case(self.write(rest), self.word("else")))
        return f'<mrow><mo>{{</mo><mtable columnalign="left left">{"".join(rows)}</mtable></mrow>'


def _case(value: str, test: str) -> str:
    return f"<mtr><mtd>{value}</mtd><mtd>{test}</mtd></mtr>"


def _row(text: str) -> str:
    """Several elements as one."""
    return f"<mrow>{text}</mrow>"

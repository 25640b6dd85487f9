"""Documentation cards: true to the code, complete, and those in the repository are current."""

from __future__ import annotations

import ast
import inspect
import math
import re
import xml.etree.ElementTree as ElementTree
from math import exp
from pathlib import Path

import numpy as np
import pytest
from er_models.card import card_markdown, card_text, index_markdown, pages, write_cards
from er_models.cards import equation as translation
from er_models.cards.equation import equations
from er_models.cards.formula import Latex, Plain
from er_models.cards.mathml import MathMl, symbol
from er_models.cards.picture import panels, svg
from er_models.cards.symbols import latex
from er_models.catalogue import CATALOGUE, Catalogue
from er_models.effect import HOOKS, Effect, Param, Signature

EFFECTS = pytest.mark.parametrize("effect", CATALOGUE.effects, ids=lambda e: e.name)
FOLDER = Path(__file__).resolve().parents[3] / "docs" / "effects"
NUMBER = re.compile(r"-?\d+\.?\d*")


@EFFECTS
def test_every_hook_becomes_a_formula(effect: Effect) -> None:
    for e in equations(effect):
        assert e.plain, e.hook
        assert e.latex.count("{") == e.latex.count("}")
        assert e.latex.count(r"\left(") == e.latex.count(r"\right)")
        assert e.latex.count(r"\begin{cases}") == e.latex.count(r"\end{cases}")
        assert e.plain.count("(") == e.plain.count(")")


@EFFECTS
def test_the_formula_is_the_code(effect: Effect) -> None:
    """The expression that is written, evaluated at random points, is what the hook returns."""
    rng = np.random.default_rng(5)
    for function in effect.hooks.values():
        value = translation._value(inspect.getsource(function))
        code = compile(ast.fix_missing_locations(ast.Expression(value)), "formula", "eval")
        names = tuple(inspect.signature(function).parameters)
        for _ in range(20):
            point = dict(zip(names, (float(x) for x in rng.uniform(0.1, 2.0, len(names)))))
            point |= {
                n: -point[n] for n in ("x", "v", "w", "f_y") if n in point and rng.random() < 0.5
            }
            found = eval(code, {**function.__globals__, **point})
            assert found == pytest.approx(function(**point), rel=1e-12)


SIGNS = {"\u2212": "-", "\u2265": ">=", "\u2264": "<=", "\u2260": "!=", "=": "==", "\u00b7": "*"}


def read(node: ElementTree.Element) -> str:
    """MathML as Python: a reader that shares nothing with what wrote it but the names of the symbols."""
    if node.tag == "msub":
        return ElementTree.tostring(node, encoding="unicode")
    parts = [read(child) for child in node]
    if not parts:
        return read_leaf(node)
    if node.tag == "msqrt":
        return f"(({''.join(parts)}) ** 0.5)"
    if node.tag in ("mfrac", "msup", "mtr"):
        return read_pair(node.tag, *parts)
    if parts[0] == parts[-1] == "|":
        return f"abs({''.join(parts[1:-1])})"
    return f"({''.join(parts[1:])})" if parts[0] == "{" else "".join(parts)


def read_pair(tag: str, first: str, second: str) -> str:
    """A fraction, a power, or a case with its test."""
    if tag == "mtr":
        return f"({first}) " + (f"{second} else " if second != " else " else "")
    if first == "<mi>e</mi>":
        return f"exp({second})"
    return f"(({first}) {'/' if tag == 'mfrac' else '**'} ({second}))"


def read_leaf(node: ElementTree.Element) -> str:
    """A symbol, a sign, a number or a word; a space is a product."""
    text = (node.text or "").strip("\u00a0")
    if node.tag == "mi":
        return text if node.get("mathvariant") else f"<mi>{text}</mi>"
    if node.tag == "mo":
        return SIGNS.get(text, text)
    return {"mspace": " * ", "mtext": f" {text} "}.get(node.tag, text.replace("\u2212", "-"))


@EFFECTS
def test_the_formula_that_is_typeset_is_the_code(effect: Effect) -> None:
    """The MathML, read back and evaluated at random points, is what the hook returns."""
    rng = np.random.default_rng(6)
    for (hook, function), e in zip(effect.hooks.items(), equations(effect), strict=True):
        tree = ElementTree.fromstring(e.mathml.replace("&nbsp;", "\u00a0"))
        assert tree.get("display") == "block"
        value = translation._value(inspect.getsource(function), translation._constants(function))
        written = translation._written(hook, value, MathMl()).replace("&nbsp;", "\u00a0")
        assert written in e.mathml.replace("&nbsp;", "\u00a0")
        text = read(ElementTree.fromstring(f"<mrow>{written}</mrow>"))
        names = tuple(inspect.signature(function).parameters)
        known = {k: v for k, v in {**vars(math), **function.__globals__}.items() if k.isalpha()}
        for name in sorted({*names, *known, "w"}, key=len, reverse=True):
            text = text.replace(symbol(name), name)
        for _ in range(10):
            point = dict(zip(names, (float(x) for x in rng.uniform(0.1, 2.0, len(names)))))
            wanted = function(**point)
            if hook == "relax":
                point.setdefault("w", 0.7)
                wanted = wanted[1] - wanted[0] * point["w"]
            assert eval(text, {**known, **point}) == pytest.approx(wanted, rel=1e-9), text


FORMULAS = {
    "a * b * a": ("a^2 b", r"a^2 \, b"),
    "a * (b + c)": ("a (b + c)", r"a \, \left(b + c\right)"),
    "a / b * c": ("(a / b) c", r"\frac{a}{b} \, c"),
    "a / (b * c)": ("a / (b c)", r"\frac{a}{b \, c}"),
    "a - (b - c)": ("a - (b - c)", r"a - \left(b - c\right)"),
    "-(a + b) ** 2": ("-(a + b)^2", r"-\left(a + b\right)^{2}"),
    "(-a) ** 2": ("(-a)^2", r"\left(-a\right)^{2}"),
    "max(-x, 0.0)": ("max(-x, 0)", r"\max\left(-x, 0\right)"),
    "abs(x) ** n": ("|x|^n", r"|x|^{n}"),
    "tau * 1e-9": ("tau 1e-9", r"\tau \, 10^{-9}"),
    "2.5e7": ("2.5e7", r"2.5 \cdot 10^{7}"),
    "a if x > 0 else b": ("a if x > 0, else b", r"\begin{cases} a & x > 0 \\ b & \text{else} \end{cases}"),
    "exp(-t / t_f)": ("exp(-t / t_f)", r"e^{-\frac{t}{t_f}}"),
    "u if x <= 1.0 and v != 0.0 else 0.0": (
        "u if x <= 1 and v != 0, else 0",
        r"\begin{cases} u & x \le 1\text{ and }v \ne 0 \\ 0 & \text{else} \end{cases}",
    ),
}  # fmt: skip


@pytest.mark.parametrize("code", FORMULAS)
def test_formula(code: str) -> None:
    node = ast.parse(code, mode="eval").body
    assert (Plain().write(node), Latex().write(node)) == FORMULAS[code]


def test_symbols() -> None:
    names = ("F_c", "k0", "k0_c", "tau", "m_us", "f_c_r", "tau_scale", "x")
    written = ["F_c", "k_0", "k_{0,c}", r"\tau", "m_{us}", "f_{c,r}", r"s_\tau", "x"]
    assert [latex(n) for n in names] == written


def looped(F_k: float, v: float) -> float:
    """Force that no formula can hold."""
    total = 0.0
    for _ in range(3):
        total += F_k * exp(-v)
    return total


def own() -> Effect:
    """A user's effect with a loop."""
    return Effect(
        "own_force", "force", "Own force", "Own.", (Param("F_k", "N", 0.0, 1.0, 0.0, (0.1,), "level"),),
        {"force": looped}, Signature("own", "force-velocity", "own"), "a test", knowable=False,
        unknowable_because="it is made up",
    )  # fmt: skip


def test_what_is_no_formula_is_shown_as_source() -> None:
    text, page = card_text(own()), card_markdown(own())
    assert "for _ in range(3):" in text
    assert "```python\ndef looped" in page
    assert "it is made up" in text
    assert "**Cannot be known:** it is made up" in page


@EFFECTS
def test_card_is_complete(effect: Effect) -> None:
    text, page = card_text(effect), card_markdown(effect)
    for card in (text, page):
        one_line = re.sub(r"\s+", " ", card).replace("- ", "-")
        for needed in (effect.title, effect.physics, effect.source, effect.signature.mark):
            assert needed.replace("- ", "-") in one_line
        for q in effect.parameters:
            assert q.name in card
            assert q.meaning in card
        assert all(HOOKS[hook] in card for hook in effect.hooks)
        assert all(rival in card for rival in effect.signature.rivals)
    assert "$$" in page
    assert max(len(line) for line in text.splitlines()) <= 140


@EFFECTS
def test_picture_shows_the_effect(effect: Effect) -> None:
    """Valid SVG, every number finite, and the curve of the effect alone is not flat."""
    drawing = svg(effect)
    root = ElementTree.fromstring(drawing)
    assert root.tag.endswith("svg")
    assert "nan" not in drawing
    assert "inf" not in drawing
    assert len(drawing) < 25_000
    for panel in panels(effect):
        assert max(np.ptp(c.y) for c in panel.curves) > 0.0
        assert np.ptp(panel.curves[-1].y) + abs(panel.curves[-1].y.mean()) > 0.02


def test_index_links_every_card() -> None:
    index = index_markdown()
    for effect in CATALOGUE.effects:
        assert f"]({effect.name}.md)" in index


@pytest.mark.slow
def test_writing_removes_cards_of_effects_that_are_gone(tmp_path: Path) -> None:
    few = Catalogue(CATALOGUE.effects[:4])
    write_cards(tmp_path, few)
    (tmp_path / "notes.md").write_text("mine", encoding="utf-8")
    gone = few.effects[-1].name
    fewer = Catalogue(few.effects)
    (tmp_path / "removed.md").write_text((tmp_path / f"{gone}.md").read_text(encoding="utf-8"))
    (tmp_path / "removed.svg").write_text("x", encoding="utf-8")
    write_cards(tmp_path, fewer)
    left = {p.name for p in tmp_path.iterdir()}
    assert left == set(pages(fewer)) | {"notes.md"}


def test_committed_cards_are_current() -> None:
    """Text to the letter, pictures to a fifth of a pixel; make them again with the command in their first line."""
    files = pages()
    committed = {p.name for p in FOLDER.glob("*.md")} | {p.name for p in FOLDER.glob("*.svg")}
    assert committed == set(files), "run: ./er exec python -m er_models.card"
    for name, text in files.items():
        found = (FOLDER / name).read_text(encoding="utf-8")
        if name.endswith(".md"):
            assert found == text, f"{name}: run: ./er exec python -m er_models.card"
            continue
        assert NUMBER.sub("#", found) == NUMBER.sub("#", text), name
        values = [np.array(NUMBER.findall(t), float) for t in (found, text)]
        assert np.abs(values[0] - values[1]).max() <= 0.21, name

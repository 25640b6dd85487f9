"""Writes the body of a hook into the place where it is called.

A body of assignments and one final return is copied with its names replaced; anything else stays a
call. This halves the time to compile and leaves a generated module that reads like the equations.
"""

from __future__ import annotations

import ast
import inspect
import math
import textwrap
from collections.abc import Callable, Mapping
from types import BuiltinFunctionType
from typing import Any

OWN = ("exp", "tanh")
"""Functions of `math` that the kernel has of its own, by the same name: see `elementary`, which takes Numba."""
_BUILTINS = {"abs": abs, "min": min, "max": max, "float": float}


def inlined(
    function: Callable[..., object], prefix: str, names: Mapping[str, str]
) -> tuple[list[str], str] | None:
    """Statements and the expression of a hook, with its arguments replaced by `names`; None: call it.

    prefix: keeps its local names apart from those of other hooks.
    """
    tree = _tree(function)
    if tree is None:
        return None
    body = [
        n for n in tree.body if not (isinstance(n, ast.Expr) and isinstance(n.value, ast.Constant))
    ]
    last = body[-1]
    if not isinstance(last, ast.Return) or last.value is None:
        return None
    if not all(isinstance(n, ast.Assign) for n in body[:-1]):
        return None
    rename = _Rename(prefix, names, getattr(function, "__globals__", {}))
    try:
        lines = [ast.unparse(rename.visit(n)) for n in body[:-1]]
        return lines, ast.unparse(rename.visit(last.value))
    except _Foreign:
        return None


def _tree(function: Callable[..., object]) -> ast.FunctionDef | None:
    """Syntax tree of a plain function; None for lambdas and where there is no source."""
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
    except (OSError, SyntaxError):
        return None
    return tree if isinstance(tree, ast.FunctionDef) and not tree.decorator_list else None


class _Foreign(Exception):
    """The hook uses something that cannot be copied."""


class _Rename(ast.NodeTransformer):
    """Replaces arguments, locals, constants of the module and mathematical functions."""

    def __init__(self, prefix: str, names: Mapping[str, str], module: Mapping[str, Any]) -> None:
        self.prefix, self.names, self.module = prefix, names, module
        self.local: set[str] = set()

    def visit_Assign(self, node: ast.Assign) -> ast.AST:
        value = self.visit(node.value)
        for target in node.targets:
            self.local |= {n.id for n in ast.walk(target) if isinstance(n, ast.Name)}
        targets = [self.visit(target) for target in node.targets]
        return ast.fix_missing_locations(ast.Assign(targets, value, lineno=1))

    def visit_Name(self, node: ast.Name) -> ast.AST:
        if node.id in self.local:
            return ast.Name(f"{self.prefix}_{node.id}", node.ctx)
        if node.id in self.names:
            return ast.parse(self.names[node.id], mode="eval").body
        return ast.parse(self._outside(node.id), mode="eval").body

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        if isinstance(node.value, ast.Name) and self.module.get(node.value.id) is math:
            return ast.parse(self._function(node.attr), mode="eval").body
        raise _Foreign

    def visit_Call(self, node: ast.Call) -> ast.AST:
        if isinstance(node.func, ast.Name) and node.func.id == "float" and not node.keywords:
            inner: ast.AST = self.visit(node.args[0])
            return inner
        self.generic_visit(node)
        return node

    def _outside(self, name: str) -> str:
        """A name that is neither argument nor local."""
        value = self.module.get(name, _BUILTINS.get(name))
        if isinstance(value, bool | int | float):
            return repr(float(value))
        if isinstance(value, BuiltinFunctionType) and getattr(math, name, None) is value:
            return self._function(name)
        if name in _BUILTINS and value is _BUILTINS[name]:
            return name
        raise _Foreign

    @staticmethod
    def _function(name: str) -> str:
        """A function of `math`, or the kernel's own for it."""
        return name if name in OWN else f"math.{name}"

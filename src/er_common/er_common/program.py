"""A program: what is known of it before it is imported, written down once in the file `programs` of its package.

Entry points, the graph of `er up`, its arguments, replay, recording and tests all read it there.
"""

from __future__ import annotations

from typing import NamedTuple

from er_common.topics import Topic

OBSERVER, CONTROLLER = "observer", "controller"
"""Kinds of which the graph's argument of that name chooses; the name of each ends with its kind."""


class Program(NamedTuple):
    """One executable.

    name: of the executable, the node and its parameters config/nodes/NAME.yaml; package: whose it is; text: what it
    does, for its help, and title: what tables call it.

    core: module with its row of `CORES`, where the node of all cores (`er_ros_common.core_node`) runs it; else module,
    usually nodes.NAME: one with a `main` and, where it is a node, with its `NODE`.

    kind: see `OBSERVER`; asked: what its own argument NAME:=true of the graph means, where it has one.
    listens: topics of the plant that it answers on says; uses: other topics, where they are there.
    beside: what else it says of each sample.
    model, rate: whether the graph tells it the file of the vehicle, the rate of the samples; gains: its own in
    config/gains, empty where it has none.
    """

    name: str
    package: str
    text: str
    title: str = ""
    core: str = ""
    module: str = ""
    kind: str = ""
    asked: str = ""
    listens: tuple[Topic, ...] = ()
    uses: tuple[Topic, ...] = ()
    says: Topic | None = None
    beside: tuple[Topic, ...] = ()
    model: bool = False
    rate: bool = False
    gains: str = ""

    @property
    def key(self) -> str:
        """How an argument of the graph calls it: unified for unified_observer."""
        return self.name.removesuffix(f"_{self.kind}")

    @property
    def said(self) -> tuple[Topic, ...]:
        """All that it says of a sample."""
        return (*(() if self.says is None else (self.says,)), *self.beside)

    @property
    def path(self) -> str:
        """Full name of its module."""
        return f"{self.package}.{self.core or self.module or f'nodes.{self.name}'}"

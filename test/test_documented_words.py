"""Every word of every documented command is one that its program knows: parsed as written, and not run.

`test_documentation` runs the commands, which takes minutes each.
"""

import argparse
import runpy
import sys
from importlib.util import find_spec

import pytest
import typer.core
from er_bringup.given import parse

from test.conftest import ROOT
from test.graph_help import STARTS
from test.test_documentation import CASES

sys.path.insert(0, str(ROOT / "tools"))

from er_workspace.commands import COMMANDS

pytestmark = pytest.mark.filterwarnings(
    "ignore:.*found in sys.modules:RuntimeWarning"  # another test has imported a program
)


class Parsed(BaseException):
    """The words of a command were understood."""


@pytest.fixture
def only_parsed(monkeypatch):
    """Programs that end once they know what they are asked for."""
    known = argparse.ArgumentParser.parse_args

    def parsed(*args, **named):
        known(*args, **named)
        raise Parsed

    def invoked(self, ctx):
        if not hasattr(self, "commands"):
            raise Parsed

    monkeypatch.setattr(argparse.ArgumentParser, "parse_args", parsed)
    base = next(c for c in typer.core.TyperCommand.__mro__ if c.__name__ == "Command")
    monkeypatch.setattr(base, "invoke", invoked)


def understood(words, monkeypatch):
    """Have the program of a command read its words."""
    name, rest = words[0], list(words[1:])
    if name == "up":
        parse([w for w in rest if not w.startswith("-")])
    elif name == "run":
        assert rest[1] in STARTS
    elif "er_bringup.integration" in " ".join(rest):
        assert find_spec(rest[2])  # made of programs' own tables: it runs in no time, and writes
    else:
        module = COMMANDS[name][2]
        if name == "exec":
            assert rest[:2] == ["python", "-m"], rest
            module, rest = rest[2], rest[3:]
        monkeypatch.setattr(sys, "argv", [name, *rest])
        with pytest.raises((Parsed, SystemExit)) as ended:
            runpy.run_module(module, run_name="__main__", alter_sys=True)
        assert isinstance(ended.value, Parsed) or not ended.value.code, ended.value


@pytest.mark.parametrize("words", CASES)
def test_the_program_knows_every_word(words, only_parsed, monkeypatch):
    understood(words, monkeypatch)


@pytest.mark.parametrize("words", [("lab", "diagnose", "DATA", "--modle", "x"), ("up", "contrller:=none"),
                                   ("study", "reach", "--sede", "1"), ("synth", "unfied"),
                                   ("control", "robust", "--sede", "3")])  # fmt: skip
def test_a_word_that_it_does_not_know_is_found(words, only_parsed, monkeypatch):
    with pytest.raises(BaseException) as found:
        understood(words, monkeypatch)
    assert not isinstance(found.value, Parsed)

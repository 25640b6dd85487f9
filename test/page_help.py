"""`lab open` as a program and its page in a browser, for tests of both."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from http.client import HTTPConnection
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("nicegui", reason="the package nicegui is not installed")
from er_studies.bench.browser import BROWSER

ROOT = str(Path(__file__).parents[1])
OPEN = ("-m", "er_model_lab.cli.app", "open", "--no-browser")
PLAYED = (
    "-c",
    f"import sys; sys.path.insert(0, {ROOT!r}); from test.played_graph import main; main()",
)
"""A page beside a graph that is played, of how many seconds before and at which pace."""
PATIENCE = 60_000.0
"""The longest that anything on a page may take on a busy machine [ms]."""


@contextmanager
def opened(*words: str, cwd: Path, program: Sequence[str] = OPEN) -> Iterator[str]:
    """The address that a program prints, by default `lab open`; ended by Ctrl-C, which must end it well."""
    command = [sys.executable, *program, *words]
    alone = {k: v for k, v in os.environ.items() if not k.startswith(("PYTEST", "NICEGUI"))}
    with subprocess.Popen(
        command, cwd=cwd, env=alone, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        try:
            yield process.stdout.readline().strip()
        finally:
            process.send_signal(signal.SIGINT)
            ended = process.wait(timeout=30)
            said = process.stderr.read()
        assert (ended, said) == (0, "")


def status(port: int, path: str, **headers: str) -> int:
    """Status of a request; _ in a header's name is a dash."""
    connection = HTTPConnection("127.0.0.1", port, timeout=20)
    connection.request("GET", path, headers={k.replace("_", "-"): v for k, v in headers.items()})
    return connection.getresponse().status


@contextmanager
def seen(*words: str, cwd: Path, program: Sequence[str] = OPEN) -> Iterator[Any]:
    """A page of a program in a browser, without errors and without a request to another host."""
    with opened(*words, cwd=cwd, program=program) as address, visited(address) as page:
        yield page


@contextmanager
def visited(address: str) -> Iterator[Any]:
    """A page in a browser, without errors and without a request to another host."""
    if BROWSER is None:
        pytest.skip("no Chromium or Chrome on this machine")
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="the package playwright is not installed"
    )
    errors, hosts = list[str](), set[str]()
    with (
        playwright.sync_playwright() as started,
        started.chromium.launch(
            executable_path=BROWSER, args=["--no-sandbox", "--disable-gpu"]
        ) as browser,
    ):
        tabs = browser.new_context(viewport={"width": 1280, "height": 900}, accept_downloads=True)
        tabs.set_default_timeout(PATIENCE)
        tabs.on("console", lambda m: errors.append(m.text) if m.type == "error" else None)
        tabs.on("weberror", lambda e: errors.append(str(e.error)))
        tabs.on(
            "request",
            lambda r: hosts.add(r.url.split("/")[2]) if r.url.startswith(("http", "ws")) else None,
        )
        made = tabs.new_page()
        made.goto(address)
        yield made
        assert errors == []
        assert hosts == ({address.split("/")[2]} if address.startswith("http") else set())

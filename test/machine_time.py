"""How much of the machine's time others had while a test ran: a plugin for tests that time themselves.

Where the machine itself stood still, such a test says nothing of what it tests. That this was so is no guess: the
kernel counts the time in which a core had work and was not given to this machine (`steal` of /proc/stat), in which
nothing that runs here has a part. A failure says how much it was, and a run in which nothing but such tests failed
ends with a status of its own, so that they can be run again.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator
from pathlib import Path
from time import monotonic, sleep

import pytest

PERIOD = 0.5
"""Time over which the share is taken [s]."""
SPOILT = 0.05
"""Share of the cores' time, in any period since a test's file began, from which on a failure proves nothing."""
CALM = 5.0
"""Time without a spoilt period that counts as calm [s]."""
NOTHING_PROVED = 75
"""Exit status of a run whose failures were all spoilt."""


def times() -> tuple[float, float]:
    """Time stolen from the cores, and all of their time, since the machine was started; (0, 0) where nobody counts."""
    try:
        first = Path("/proc/stat").read_text(encoding="ascii").split("\n", 1)[0].split()
    except OSError:
        return 0.0, 0.0
    counts = [float(each) for each in first[1:9]]
    return (counts[7] if len(counts) > 7 else 0.0), sum(counts)


class Ledger:
    """Share of stolen time by period; look: to be called once a period."""

    def __init__(self, read: Callable[[], tuple[float, float]] = times) -> None:
        self._read, self._before = read, read()
        self.shares: list[tuple[float, float]] = []

    def look(self, now: float) -> None:
        """Take down the share since the last look; now: on the steady clock [s]."""
        stolen, whole = self._read()
        passed = whole - self._before[1]
        if passed > 0.0:
            self.shares.append((now, (stolen - self._before[0]) / passed))
            self._before = stolen, whole

    def worst(self, since: float) -> float:
        """Largest share of the periods that ended after a time [s]."""
        return max((share for when, share in self.shares if when >= since), default=0.0)


class MachineTime:
    """The ledger beside the tests."""

    def __init__(self, spoilt: Path | None) -> None:
        self.ledger, self.file = Ledger(), spoilt
        self.begun: dict[str, float] = {}
        self.spoilt: list[str] = []
        self.proved = 0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._keep, daemon=True)

    def _keep(self) -> None:
        while not self._over.wait(PERIOD):
            self.ledger.look(monotonic())

    def calm(self, at_most: float) -> None:
        """Wait until nothing was stolen for a while, or for so long [s]."""
        begun = monotonic()
        while monotonic() - begun < at_most:
            sleep(PERIOD)
            quiet = monotonic() - begun >= CALM
            if quiet and self.ledger.worst(monotonic() - CALM) < SPOILT:
                return

    def pytest_sessionstart(self, session: pytest.Session) -> None:
        self._thread.start()
        self.calm(session.config.getoption("--calm"))

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        # what the tests of a file share may have been made by its first one
        self.begun.setdefault(nodeid.partition("::")[0], monotonic())

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        report = yield
        if report.failed:
            file, _, name = item.nodeid.partition("::")
            self.ledger.look(monotonic())
            worst = self.ledger.worst(self.begun[file])
            report.sections.append(
                ("machine", f"others had up to {100.0 * worst:.0f} % of it for {PERIOD:g} s")
            )
            if worst < SPOILT:
                self.proved += 1
            else:
                self.spoilt.append(f"{item.path}::{name}")
        return report

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        self._over.set()
        whole = not (session.shouldfail or session.shouldstop)
        if self.spoilt and not self.proved and whole and session.exitstatus == 1 and self.file:
            self.file.write_text("\n".join(dict.fromkeys(self.spoilt)), encoding="utf-8")
            session.exitstatus = NOTHING_PROVED


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("machine time")
    group.addoption(
        "--spoilt", type=Path, metavar="FILE",
        help=f"where only tests failed that others had the machine beside: list them there, exit with {NOTHING_PROVED}",
    )  # fmt: skip
    group.addoption(
        "--calm", type=float, default=0.0, metavar="SECONDS",
        help="wait for a calm machine first, for so long at most",
    )  # fmt: skip
    group.addoption(
        "--pace", type=float, default=1.0, metavar="FACTOR",
        help="pace of simulated worlds against real time, in tests of running graphs that can do with a slower one",
    )  # fmt: skip


def pytest_configure(config: pytest.Config) -> None:
    config.pluginmanager.register(MachineTime(config.getoption("--spoilt")))

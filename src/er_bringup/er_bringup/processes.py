"""Child processes with prefixed output, stopped in order and never left behind."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from time import monotonic, sleep
from typing import IO

from er_models.errors import InputError
from er_models.orphan import end_with_parent

PATIENCE = 8.0
"""Time to end after SIGINT; a recorder may have to write its index [s]."""
LAST_PATIENCE = 2.0
"""Time to end after SIGTERM, before SIGKILL [s]."""
RESPAWN = 2.0
"""Time after which a process that ended badly is started again, where that is asked for [s]."""
POLL = 0.02
KILLED = 128
"""Exit status of a process ended by signal n is this plus n, as shells say it."""


def say(line: str, out: IO[str]) -> None:
    """Write a line at once, unless nobody reads any more."""
    with suppress(OSError, ValueError):
        out.write(f"{line}\n")
        out.flush()


class Child:
    """One running process; its lines appear on `out` behind its label.

    Raises:
        InputError: The system does not start the program.
    """

    def __init__(self, label: str, argv: Sequence[str], out: IO[str]) -> None:
        self.label, self._unready = label, False
        try:
            self.process = _started(argv)
        except OSError as error:
            expected = "a program that can be started"
            raise InputError(argv[0], "", expected, f"'{error.strerror}'") from None
        self._reader = threading.Thread(target=self._copy, args=(out,), daemon=True)
        self._reader.start()

    def _copy(self, out: IO[str]) -> None:
        assert self.process.stdout is not None
        with self.process.stdout as lines:
            for line in lines:
                # where nobody reads any more, a node must not wait for room in its pipe
                say(f"[{self.label}] {line.rstrip()}", out)

    @property
    def status(self) -> int | None:
        """Exit status, None while it runs; 128 + n where signal n ended it.

        0 where it was asked to end before it had got so far as to take requests.
        """
        code = self.process.poll()
        if self._unready and code == -signal.SIGTERM:
            return 0
        return code if code is None or code >= 0 else KILLED - code

    def ask(self) -> None:
        """Ask it to end: as Ctrl-C does, or by SIGTERM while it is still being imported.

        Python turns Ctrl-C into a traceback wherever it is; a program of ours takes SIGTERM once it is ready to.
        """
        if self.process.poll() is not None:
            return
        self._unready = not _takes(self.process.pid, signal.SIGTERM)
        self.send(signal.SIGTERM if self._unready else signal.SIGINT)

    def send(self, number: int) -> None:
        """Send a signal, unless it has ended."""
        if self.process.poll() is None:
            self.process.send_signal(number)

    def finish(self) -> None:
        """Wait for the last lines of an ended process."""
        self._reader.join(timeout=2.0)


def _started(argv: Sequence[str]) -> subprocess.Popen[str]:
    """A process with one stream of lines."""
    # a session of its own: Ctrl-C on the terminal reaches it through us, once
    return subprocess.Popen(
        argv,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        start_new_session=True,
        preexec_fn=end_with_parent,
    )


def stop(children: Sequence[Child]) -> None:
    """End all of these: Ctrl-C, then SIGTERM, then SIGKILL for the whole session."""
    for child in children:
        child.ask()
    if not _ended(children, PATIENCE):
        for child in children:
            child.send(signal.SIGTERM)
        _ended(children, LAST_PATIENCE)
    for child in children:
        if child.status is None:
            os.killpg(child.process.pid, signal.SIGKILL)
            child.process.wait()
        child.finish()


def _takes(pid: int, number: int) -> bool:
    """Whether a process handles a signal; taken for granted where the system does not tell."""
    try:
        status = Path(f"/proc/{pid}/status").read_text(encoding="ascii")
    except OSError:
        return True
    caught = re.search(r"^SigCgt:\s*([0-9a-f]+)", status, re.M)
    return caught is None or bool(int(caught[1], 16) >> (number - 1) & 1)


def worst(statuses: Mapping[str, int]) -> int:
    """The exit status that says most: the largest."""
    return max(statuses.values(), default=0)


def _ended(children: Sequence[Child], patience: float) -> bool:
    """Whether all ended within this time [s]."""
    until = monotonic() + patience
    while any(child.status is None for child in children):
        if monotonic() > until:
            return False
        sleep(POLL)
    return True

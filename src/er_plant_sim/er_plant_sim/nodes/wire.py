"""The thread that holds the wire: opens it, reads it, opens it again when it is gone."""

from __future__ import annotations

import threading
from collections.abc import Callable
from time import monotonic, monotonic_ns

from er_plant_sim.hardware.link import Address, Link, connect

ATTENTION = 0.005
"""Longest wait for bytes [s]; then it is time for what has to be done now and then."""
AGAIN = 0.2
"""Time between two attempts to open a wire [s]."""


class Wire:
    """Calls `heard(data, now, datagram)` for bytes and `idle(now)` often; what they want to send they `write`.

    trouble: what is wrong with the wire now, "" while it is open and takes what is written; opens, failed: times it
    was opened, writes that failed.
    """

    def __init__(
        self,
        address: Address,
        heard: Callable[[bytes, int, bool], None],
        idle: Callable[[int], None],
        opened: Callable[[], None],
    ) -> None:
        self.address, self.heard, self.idle, self.opened = address, heard, idle, opened
        self.trouble, self.opens, self.failed = "", 0, 0
        self._link: Link | None = None
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, name="wire", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    @property
    def dead(self) -> bool:
        """Whether the thread has ended although nobody asked it to."""
        t = self._thread
        return t.ident is not None and not t.is_alive() and not self._ending.is_set()

    def write(self, data: bytes) -> None:
        """Send bytes, from any thread; without a wire they are lost."""
        link = self._link
        if link is not None and data:
            try:
                link.write(data)
            except (OSError, ValueError, TypeError) as error:  # or closed by the other thread
                self.trouble = str(error)
                self.failed += 1
            else:
                self.trouble = ""

    def stop(self, farewell: Callable[[], bytes]) -> None:
        """End the thread, send what is asked for only then, so that nothing follows it, and close the wire."""
        self._ending.set()
        if self._thread.is_alive():
            self._thread.join(timeout=1.0)
        self.write(farewell())
        self._close()

    def _run(self) -> None:
        while not self._ending.is_set():
            # whatever a driver or listener raises: the rig is lost only with this thread
            for part in (self._connected, self._wait):
                try:
                    part()
                except Exception as error:
                    self.trouble = _words(error)

    def _connected(self) -> None:
        """Open the wire and serve it until it is gone."""
        self._link = connect(self.address)
        self.trouble, self.opens = "", self.opens + 1
        self.opened()
        self._serve(self._link)

    def _close(self) -> None:
        link, self._link = self._link, None
        if link is not None:
            link.close()

    def _wait(self) -> None:
        """Do nothing but what has to be done now and then until it is time to open the wire again."""
        if self._ending.is_set():
            return  # the farewell is still to be sent
        self._close()
        until = monotonic() + AGAIN
        while monotonic() < until and not self._ending.wait(ATTENTION):
            self.idle(monotonic_ns())

    def _serve(self, link: Link) -> None:
        while not self._ending.is_set():
            data = link.read(ATTENTION)
            now = monotonic_ns()
            if data:
                self.heard(data, now, link.datagram)
            self.idle(now)


def _words(error: Exception) -> str:
    """What is wrong, for people."""
    if isinstance(error, OSError):
        return error.strerror or str(error)
    return f"{type(error).__name__}: {error}"

"""The thread that holds the wire, with a pseudo terminal and with a link that is told to fail."""

from __future__ import annotations

import os
import socket
import termios
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import monotonic, process_time, sleep

import pytest
from er_plant_sim.hardware import frame
from er_plant_sim.hardware.frame import Sync
from er_plant_sim.hardware.link import Address, PtyLink, UdpLink
from er_plant_sim.nodes import wire as module
from er_plant_sim.nodes.wire import AGAIN, Wire


def until(holds: Callable[[], bool], seconds: float = 5.0) -> None:
    """Wait for something."""
    end = monotonic() + seconds
    while not holds():
        assert monotonic() < end
        sleep(0.002)


def killed(device: PtyLink) -> None:
    """Take the terminal away as the kernel does with that of a killed program: the link stays."""
    os.close(device._master)
    os.close(device._slave)


def test_a_port_whose_device_died_is_opened_again_and_costs_nothing_meanwhile(
    tmp_path: Path,
) -> None:
    port = tmp_path / "port"
    device, calls = PtyLink(str(port)), [0]

    def idle(_: int) -> None:
        calls[0] += 1
        wire.write(b"?")

    wire = Wire(Address(f"serial:{port}", ("serial",)), lambda *_: None, idle, lambda: None)
    wire.start()
    try:
        until(lambda: device.read(0.0) == b"?")
        assert (wire.opens, wire.trouble) == (1, "")
        killed(device)
        until(lambda: wire.trouble != "")
        before, began = calls[0], process_time()
        sleep(2.0 * AGAIN)
        assert wire.trouble
        # silence is noticed in time, and nothing spins
        assert 10 < calls[0] - before < 200
        assert process_time() - began < 0.5 * AGAIN
        device = PtyLink(str(port))
        until(lambda: device.read(0.0) == b"?")
        assert (wire.opens, wire.trouble) == (2, "")
    finally:
        wire.stop(bytes)
        device.close()


class Failing:
    """A link that takes nothing while it is told so."""

    datagram = True

    def __init__(self) -> None:
        self.fails, self.written, self.last, self.closed = False, 0, b"", False

    def read(self, timeout: float) -> bytes:
        """The same again, soon."""
        sleep(0.2 * timeout)
        return b"sample"

    def write(self, data: bytes) -> None:
        """Count, or fail as a network does that is away for a moment."""
        if self.fails:
            raise OSError(101, "Network is unreachable")
        self.written += 1
        self.last = data

    def close(self) -> None:
        """Nothing is written from then on."""
        self.closed = True


def test_a_write_that_failed_is_forgiven_by_the_next_that_does_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    link = Failing()
    monkeypatch.setattr(module, "connect", lambda _: link)
    wire = Wire(
        Address("udp:h:1", ("udp",)), lambda *_: None, lambda _: wire.write(b"?"), lambda: None
    )
    wire.start()
    try:
        until(lambda: link.written > 3)
        link.fails = True
        until(lambda: "unreachable" in wire.trouble)
        link.fails = False
        until(lambda: not wire.trouble)
        assert wire.failed > 0
        assert wire.opens == 1
    finally:
        wire.stop(bytes)


@pytest.mark.parametrize("place", ["open", "read", "heard", "idle"])
def test_whatever_goes_wrong_is_said_and_the_wire_opened_again(
    monkeypatch: pytest.MonkeyPatch, place: str
) -> None:
    monkeypatch.setattr(module, "AGAIN", 0.02)
    link, ill = Failing(), [True]

    def failing(where: str, *_: object) -> bytes:
        """What a driver raises whose port hangs up while it is opened, in one place."""
        if ill[0] and where == place:
            raise termios.error(5, "Input/output error")
        return b"?"

    def opened(_: Address) -> Failing:
        failing("open")
        return link

    monkeypatch.setattr(module, "connect", opened)
    monkeypatch.setattr(link, "read", lambda _: sleep(0.001) or failing("read"))

    def said(where: str, *_: object) -> None:
        wire.write(failing(where))

    heard, idle = partial(said, "heard"), partial(said, "idle")
    wire = Wire(Address("udp:h:1", ("udp",)), heard, idle, lambda: None)
    wire.start()
    try:
        until(lambda: "Input/output error" in wire.trouble)
        ill[0] = False
        written = link.written
        until(lambda: not wire.trouble and link.written > written + 3)
        assert not wire.dead
    finally:
        wire.stop(bytes)
    assert not wire.dead


def test_a_thread_that_ended_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Wire, "_run", lambda _: None)
    wire = Wire(Address("udp:h:1", ("udp",)), lambda *_: None, lambda _: None, lambda: None)
    assert not wire.dead
    wire.start()
    until(lambda: wire.dead)
    wire.stop(bytes)


def test_nothing_follows_the_farewell(monkeypatch: pytest.MonkeyPatch) -> None:
    link, answers = Failing(), [0]
    monkeypatch.setattr(module, "connect", lambda _: link)

    def heard(*_: object) -> None:
        """The duty that a sample is answered with, which takes its time."""
        sleep(0.01)
        answers[0] += 1
        wire.write(b"duty")

    wire = Wire(Address("udp:h:1", ("udp",)), heard, lambda _: None, lambda: None)
    wire.start()
    until(lambda: link.written > 3)

    def farewell() -> bytes:
        assert not link.closed
        return b"safe %d" % answers[0]

    wire.stop(farewell)
    sleep(0.05)
    # the answer that was being made came before it, and it was numbered after that
    assert link.last == b"safe %d" % answers[0]
    assert link.closed
    wire.write(b"duty of a command that came late")
    assert link.last == b"safe %d" % answers[0]


def test_a_device_answers_whoever_sent_the_last_whole_frame() -> None:
    def end() -> socket.socket:
        made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        made.bind(("127.0.0.1", 0))
        made.settimeout(0.2)
        return made

    with end() as free:
        port = free.getsockname()[1]
    device = UdpLink("127.0.0.1", port, listen=True)
    good = frame.encode(Sync(1), 1)
    broken, foreign = good[:-1] + bytes([good[-1] ^ 1]), good[:2] + b"\x02" + good[3:]
    with end() as host, end() as stranger:

        def answered(sender: socket.socket, data: bytes) -> bool:
            sender.sendto(data, ("127.0.0.1", port))
            assert device.read(1.0) == data
            device.write(b"answer")
            try:
                return sender.recv(100) == b"answer"
            except TimeoutError:
                return False

        assert not answered(stranger, b"noise")
        assert answered(host, good)
        assert not any(answered(stranger, each) for each in (b"noise", broken, foreign))
        assert answered(stranger, good)
        assert answered(host, good)
    device.close()

"""Wires to a device: serial ports and UDP, and the other ends of both for a device that is a program.

A wire is named by a text: `serial:/dev/ttyUSB0` (`serial:/dev/ttyUSB0@460800` where the speed is not 921600
baud), `udp:HOST:PORT`. A device listens at `udp:HOST:PORT`, or makes a pseudo terminal and a link to it:
`pty:er-device`, which the host opens as `serial:er-device`. The folder must be one to which only trusted users write
(not the one of temporary files): whoever can put another link there gets the commands.
"""

from __future__ import annotations

import errno
import os
import select
import socket
import termios
import tty
from pathlib import Path
from typing import Any, Protocol, TypeAlias

from er_models.errors import InputError

from er_plant_sim.hardware import parser
from er_plant_sim.hardware.parser import ParserState

BAUD = 921600
HOST_WIRES = ("serial", "udp")
"""Kinds of wires that the host can open."""
CHUNK = 65536
WRITE_TIMEOUT = 0.02
"""Longest time a write may hold up the loop [s]; what does not fit by then is lost."""
Sender: TypeAlias = tuple[str, int] | None
"""Host and port of who sent a datagram."""


class Link(Protocol):
    """An open wire; everything but `close` raises OSError when it is gone."""

    datagram: bool
    sender: Sender
    """Who sent what was read last, where the wire knows that."""

    def read(self, timeout: float) -> bytes:
        """Bytes that came within this time [s]; none is an answer too."""

    def write(self, data: bytes, to: Sender = None, /) -> None:
        """Send bytes, to the other end where nobody is named; what the wire does not take at once is lost."""

    def close(self) -> None:
        """Give the wire back."""


class Address:
    """A wire's name, checked.

    Raises:
        InputError: It is of no known form.
    """

    def __init__(self, text: str, kinds: tuple[str, ...], where: str = "link") -> None:
        forms = {
            "serial": "serial:PORT or serial:PORT@BAUD",
            "udp": "udp:HOST:PORT",
            "pty": "pty:PATH of the link to make",
        }
        expected = ", ".join(forms[kind] for kind in kinds)
        self.kind, _, rest = text.partition(":")
        if self.kind not in kinds or not rest:
            raise InputError(where, "", expected, f"'{text}'")
        self.place, self.number = rest, BAUD
        if self.kind == "udp" or (self.kind == "serial" and "@" in rest):
            self.place, _, number = rest.rpartition(":" if self.kind == "udp" else "@")
            if not self.place or not number.isdecimal() or not 0 < int(number) < 2**31:
                raise InputError(where, "", expected, f"'{text}'")
            self.number = int(number)
        if self.kind == "udp" and self.number > 65535:
            raise InputError(where, "", "a port of at most 65535", f"'{text}'")


class SerialLink:
    """A serial port."""

    datagram = False
    sender: Sender = None

    def __init__(self, port: str, baud: int) -> None:
        import serial

        self._port: Any = serial.Serial(
            port, baud, timeout=0, write_timeout=WRITE_TIMEOUT, exclusive=True
        )
        self._port.reset_input_buffer()

    def read(self, timeout: float) -> bytes:
        """Bytes that came within this time [s]; OSError once the other end has hung up."""
        ready, _, _ = select.select([self._port.fileno()], [], [], timeout)
        if not ready:
            return b""
        data = os.read(self._port.fileno(), CHUNK)
        if not data:  # from then on it would be ready, with nothing, for ever
            raise OSError(errno.ENODEV, "the port is gone")
        return data

    def write(self, data: bytes, _: Sender = None, /) -> None:
        """Send bytes."""
        self._port.write(data)

    def close(self) -> None:
        """Give the port back."""
        self._port.close()


class UdpLink:
    """UDP to a device, or with `listen` the device's side.

    peer: whom that answers: whoever sent the last whole frame of version 1. With `follow` false nobody, until the
    device has found out who sent a frame that it believes, and says so.
    """

    datagram = True

    def __init__(self, host: str, port: int, *, listen: bool = False, follow: bool = True) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self.sender: Sender = None
        self.peer: Sender = None if listen else (host, port)
        self._follow = follow
        if listen:
            self._socket.bind((host, port))
        else:
            self._socket.connect((host, port))

    def read(self, timeout: float) -> bytes:
        """One datagram, if one came within this time [s]."""
        ready, _, _ = select.select([self._socket], [], [], timeout)
        if not ready:
            return b""
        try:
            data, self.sender = self._socket.recvfrom(CHUNK)
        except ConnectionRefusedError:  # nobody listens there yet
            return b""
        if self._follow and self.sender != self.peer and parser.step(ParserState(), data)[1]:
            self.peer = self.sender
        return data

    def write(self, data: bytes, to: Sender = None, /) -> None:
        """Send one datagram."""
        there = to or self.peer
        if there is not None:
            try:
                self._socket.sendto(data, there) if self._listens else self._socket.send(data)
            except (BlockingIOError, ConnectionRefusedError):
                return

    @property
    def _listens(self) -> bool:
        try:
            self._socket.getpeername()
        except OSError:
            return True
        return False

    def close(self) -> None:
        """Give the socket back."""
        self._socket.close()


class PtyLink:
    """The device's end of a pseudo terminal, with a link to the host's end at a path."""

    datagram = False
    sender: Sender = None

    def __init__(self, path: str) -> None:
        self._path = Path(path)
        if self._path.exists() and not self._path.is_symlink():
            raise InputError(path, "", "a path for a link", "a file with that name")
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave, termios.TCSANOW)
        os.set_blocking(self._master, False)
        self._path.unlink(missing_ok=True)
        self._path.symlink_to(os.ttyname(self._slave))

    def read(self, timeout: float) -> bytes:
        """Bytes that came within this time [s]."""
        ready, _, _ = select.select([self._master], [], [], timeout)
        return os.read(self._master, CHUNK) if ready else b""

    def write(self, data: bytes, _: Sender = None, /) -> None:
        """Send bytes; without a reader they are lost, as on a wire that ends nowhere."""
        try:
            os.write(self._master, data)
        except BlockingIOError:
            return

    def close(self) -> None:
        """Remove link and terminal."""
        self._path.unlink(missing_ok=True)
        os.close(self._master)
        os.close(self._slave)


def connect(address: Address) -> Link:
    """The host's side of a wire; OSError where it is not there."""
    if address.kind == "udp":
        return UdpLink(address.place, address.number)
    return SerialLink(address.place, address.number)


def listen(address: Address, *, follow: bool = True) -> Link:
    """A device's side of a wire; OSError where it cannot be had. follow: see `UdpLink`."""
    if address.kind == "pty":
        return PtyLink(address.place)
    if address.kind == "udp":
        return UdpLink(address.place, address.number, listen=True, follow=follow)
    return SerialLink(address.place, address.number)

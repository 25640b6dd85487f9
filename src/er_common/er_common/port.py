"""Ports of this machine."""

from __future__ import annotations

import socket

from er_models.errors import InputError

HOST = "127.0.0.1"
"""The only address that anything is served at."""


def free_port(asked: int | None = None) -> int:
    """A port of this machine: the one asked for, else any.

    Raises:
        InputError: It is in use, or not allowed.
    """
    with socket.socket() as found:
        try:
            found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            found.bind((HOST, asked or 0))
        except (OSError, OverflowError) as error:
            raise InputError("--port", "", "a port that is free", f"{asked}: {error}") from None
        return int(found.getsockname()[1])

"""Serves the desk to browsers of this machine."""

from __future__ import annotations

import asyncio
import logging
import secrets
import socket
import webbrowser
from collections.abc import Callable

from er_models.errors import InputError
from nicegui import app, ui

from er_model_lab.page.guard import Guard, Pass
from er_model_lab.page.view import View
from er_model_lab.session import dropped
from er_model_lab.session.desk import Desk

HOST = "127.0.0.1"


def free_port(asked: int | None) -> int:
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


def serve(desk: Desk, *, port: int | None, browser: bool, say: Callable[[str], None]) -> None:
    """Serve until the program is ended; say: told the address once the page can be opened."""
    port, token = free_port(port), secrets.token_urlsafe(24)
    hosts = frozenset({f"{HOST}:{port}", f"localhost:{port}"})
    app.add_middleware(Guard, wanted=Pass(hosts, token, dropped.LARGEST))  # type: ignore[arg-type]

    @ui.page("/")
    def page() -> None:
        View(desk)

    async def ready() -> None:
        for _ in range(200):
            try:
                _, writer = await asyncio.open_connection(HOST, port)
            except OSError:
                await asyncio.sleep(0.02)
                continue
            writer.close()
            break
        address = f"http://{HOST}:{port}/?token={token}"
        say(address)
        if browser:
            await asyncio.get_running_loop().run_in_executor(None, webbrowser.open, address)

    logging.getLogger("nicegui").setLevel(logging.ERROR)
    app.on_startup(lambda: asyncio.create_task(ready()))
    app.on_shutdown(desk.shut)
    ui.run(
        host=HOST, port=port, title="Model lab", show=False, reload=False, dark=None, show_welcome_message=False,
        language="en-US", favicon=FAVICON, uvicorn_logging_level="error", access_log=False, reconnect_timeout=30.0,
        forwarded_allow_ips="",
    )  # fmt: skip


FAVICON = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 16 16"><path d="M1 9h3l2-6 3 11 2-5h4" fill="none" '
    'stroke="#c24f00" stroke-width="1.8"/></svg>'
)

"""Serves the desk to browsers of this machine."""

from __future__ import annotations

import asyncio
import logging
import secrets
import webbrowser
from collections.abc import Callable
from threading import Thread

from nicegui import app, ui

from er_model_lab.page.guard import Guard, Pass
from er_model_lab.page.view import View
from er_model_lab.session import dropped
from er_model_lab.session.desk import Desk


def serve(
    desk: Desk, *, host: str, port: int, browser: bool, say: Callable[[str], None],
    beside: Callable[[], None] | None = None,
) -> None:  # fmt: skip
    """Serve until the program is ended; say: told the address once the page can be opened.

    beside: what goes on beside the page, in a thread of its own; the page ends with it.
    """
    token = secrets.token_urlsafe(24)
    hosts = frozenset({f"{host}:{port}", f"localhost:{port}"})
    app.add_middleware(Guard, wanted=Pass(hosts, token, dropped.LARGEST))  # type: ignore[arg-type]

    @ui.page("/")
    def page() -> None:
        View(desk)

    async def ready() -> None:
        for _ in range(200):
            try:
                _, writer = await asyncio.open_connection(host, port)
            except OSError:
                await asyncio.sleep(0.02)
                continue
            writer.close()
            break
        address = f"http://{host}:{port}/?token={token}"
        say(address)
        if browser:
            await asyncio.get_running_loop().run_in_executor(None, webbrowser.open, address)
        if beside is not None:
            Thread(target=go_on, args=(asyncio.get_running_loop(), beside), daemon=True).start()

    def go_on(loop: asyncio.AbstractEventLoop, beside: Callable[[], None]) -> None:
        try:
            beside()
        finally:
            loop.call_soon_threadsafe(app.shutdown)

    logging.getLogger("nicegui").setLevel(logging.ERROR)
    app.on_startup(lambda: asyncio.create_task(ready()))
    app.on_shutdown(desk.shut)
    # a bar without a name tells a screen reader nothing, and others nothing that the page does not show
    app.config.quasar_config["loadingBar"]["skipHijack"] = True
    # nothing is packed: within one machine that takes longer than it saves
    ui.run(
        host=host, port=port, title="Model lab", show=False, reload=False, dark=None, show_welcome_message=False,
        language="en-US", favicon=FAVICON, uvicorn_logging_level="error", access_log=False, reconnect_timeout=30.0,
        forwarded_allow_ips="", gzip_middleware_factory=None,
    )  # fmt: skip


FAVICON = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 16 16"><path d="M1 9h3l2-6 3 11 2-5h4" fill="none" '
    'stroke="#c24f00" stroke-width="1.8"/></svg>'
)

"""The live page as `er lab open --live` serves it, but that it diagnoses nothing by itself: what looking on costs."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from er_common.port import HOST, free_port
from er_model_lab.page.server import serve
from er_model_lab.session.live_desk import LiveDesk


def main() -> None:
    """Serve until Ctrl-C; the address is printed."""
    with TemporaryDirectory() as folder:
        desk = LiveDesk(Path(folder), "")
        desk.by_itself = False
        serve(desk, host=HOST, port=free_port(), browser=False, say=partial(print, flush=True))


if __name__ == "__main__":
    main()

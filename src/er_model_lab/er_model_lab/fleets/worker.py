"""What a Dask process of this machine does first: Ctrl-C is for who asks, who then ends it."""

from __future__ import annotations

import signal
from typing import Any


def dask_setup(worker: Any) -> None:
    """Called by Dask, in the worker's main thread."""
    del worker
    signal.signal(signal.SIGINT, signal.SIG_IGN)

"""What a user waits for at the page in a browser, in times of a yardstick: 10 million additions of Python.

The command is typed; its address is printed; the page shows the curves. A parameter is moved by a key, again and again:
from the key to the curves that Plotly has drawn. *Diagnose* is clicked; the first ranked effect stands there. The
processor time is that of the thread that draws; waits grow with what else the machine does, it hardly does.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from er_models.errors import InputError

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
BROWSER = next((path for name in BROWSERS if (path := shutil.which(name))), None)
TARGETS = {
    "command to address": 3.0,
    "command to curves": 6.0,
    "key on a slider to curves, p95": 0.2,
    "click to the first ranked effect": 3.0,
    "processor time of the browser for the curves": 4.0,
    "processor time of the browser for a key": 0.2,
}
"""Most times of the yardstick, which takes 0.5 s on the machine that the targets are for."""
SHOWN = "the page shows the graph"
"""What `watch` says."""
REST = 2.0
"""Time in which everything is drawn that is under way [s]."""
KEYS = 40
"""How often a key moves the slider."""
LONGEST = 60.0
"""Most that anything may take [s]."""
_STAMPS = """(plot) => {
  window.stamps = {key: 0, drawn: 0};
  document.addEventListener("keydown", () => { window.stamps = {key: performance.now(), drawn: 0}; }, true);
  plot.on("plotly_afterplot", () => { window.stamps.drawn ||= performance.now(); });
}"""


def found() -> bool:
    """Whether there are a browser, what drives it, and the page."""
    return BROWSER is not None and all(find_spec(name) for name in ("playwright", "nicegui"))


def yardstick() -> float:
    """Time of 10 million additions [s]."""
    began, total = time.perf_counter(), 0
    for k in range(10_000_000):
        total += k
    return time.perf_counter() - began


def waits(data: Path, model: Path) -> dict[str, float]:
    """How long each of `TARGETS` took, in its order [s]; a browser is there already.

    Raises:
        InputError: `found` is false.
    """
    if not found():
        raise InputError("browser", "", f"one of {', '.join(BROWSERS)}, and playwright", "none")
    from playwright.sync_api import sync_playwright

    with (
        sync_playwright() as started,
        started.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"]) as browser,
    ):
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        page.set_default_timeout(1e3 * LONGEST)
        asked = page.context.new_cdp_session(page)
        asked.send("Performance.enable", {"timeDomain": "threadTicks"})

        def used() -> float:
            told = asked.send("Performance.getMetrics")["metrics"]
            return float(next(m["value"] for m in told if m["name"] == "TaskDuration"))

        began = time.perf_counter()
        with _opened(data, model) as address:
            took = [time.perf_counter() - began]
            page.goto(address)
            page.locator(".scatterlayer .trace").first.wait_for()
            took.append(time.perf_counter() - began)
            drawn = used()
            page.get_by_role("tab", name="Play").click()
            page.wait_for_timeout(1e3 * REST)
            before = used()
            took.append(_moved(page))
            page.wait_for_timeout(1e3 * REST)
            key = (used() - before) / KEYS
            took += [_diagnosed(page), drawn, key]
    return dict(zip(TARGETS, took, strict=True))


def watch(address: str) -> None:
    """Show a live page until a signal comes, with what all others leave of the machine; says when the graph is seen."""
    from playwright.sync_api import sync_playwright

    os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    with (
        suppress(KeyboardInterrupt),
        sync_playwright() as started,
        started.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"]) as browser,
    ):
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        page.set_default_timeout(1e3 * LONGEST)
        page.goto(address)
        page.get_by_text("live error").first.wait_for()
        page.locator(".scatterlayer .trace").first.wait_for()
        sys.stdout.write(f"{SHOWN}\n")
        sys.stdout.flush()
        page.wait_for_timeout(1e9)


@contextmanager
def _opened(data: Path, model: Path) -> Iterator[str]:
    """The address of a page over data and a model."""
    command = [sys.executable, "-m", "er_model_lab.cli.app", "open", "--no-browser"]
    with subprocess.Popen(
        [*command, str(data), "--model", str(model)], stdout=subprocess.PIPE, text=True
    ) as process:
        try:
            yield process.stdout.readline().strip() if process.stdout else ""
        finally:
            process.send_signal(signal.SIGINT)


def _moved(page: Any) -> float:
    """A slider is moved by keys: from the key to the curves, p95 [s]."""
    from er_model_lab.page.view import PLOTS

    figure = page.locator(f'[aria-label="{PLOTS["force"][1]}"]')
    plot = figure.locator(".js-plotly-plot").or_(figure.and_(page.locator(".js-plotly-plot")))
    plot.first.evaluate(_STAMPS)
    page.get_by_role("tab", name="Play").click()
    thumb = page.locator('[data-parameter="passive.c0"] [tabindex="0"]')
    took = np.empty(KEYS)
    for k in range(KEYS):
        thumb.press("ArrowRight")
        page.wait_for_function("window.stamps.drawn > 0", polling=20)
        stamps = page.evaluate("window.stamps")
        took[k] = 1e-3 * (stamps["drawn"] - stamps["key"])
    return float(np.percentile(took, 95.0))


def _diagnosed(page: Any) -> float:
    """*Diagnose* is clicked: until the first effect is ranked [s]; then the job is cancelled."""
    page.get_by_role("tab", name="Learn").click()
    page.get_by_role("button", name="Diagnose").wait_for()
    began = time.perf_counter()
    page.get_by_role("button", name="Diagnose").click()
    page.get_by_text(re.compile(r"^1\. .* less$")).first.wait_for()
    took = time.perf_counter() - began
    page.get_by_role("button", name="Cancel").click()
    return took


if __name__ == "__main__":
    watch(sys.argv[1])

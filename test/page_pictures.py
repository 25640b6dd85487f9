"""The pictures of docs/open.md: `./er exec python -m test.page_pictures` takes them in the system's browser.

Needs Chromium and the package playwright, as the tests of the page do.
"""

import io
import shutil
import signal
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from pathlib import Path

from PIL import Image

from test.conftest import ROOT
from test.sample import write_sample

PICTURES = ROOT / "docs" / "pictures"
WIDE, PHONE = {"width": 1280, "height": 800}, {"width": 390, "height": 844}
PATIENCE = 300_000.0
"""The longest that anything may take [ms]."""


@contextmanager
def served(folder):
    """The address of a page over measurements with a friction that the model lacks."""
    data = write_sample(folder / "run.csv", seed=1, seconds=14.0)
    command = [
        sys.executable,
        "-m",
        "er_model_lab.cli.app",
        "open",
        str(data),
        "--model",
        "inove_guo",
        "--no-browser",
    ]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        yield process.stdout.readline().strip()
        process.send_signal(signal.SIGINT)


def take(page, name):
    """One picture, small enough for a repository."""
    page.wait_for_timeout(2500)
    shot = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    shot.save(PICTURES / f"open_{name}.webp", quality=75, method=6)


def walk(page):
    """Look, play, learn, add: a picture of each."""
    page.locator("header").get_by_text("held out").wait_for()
    curves, tiles = (page.locator(".js-plotly-plot").nth(k).bounding_box() for k in (0, 1))
    page.mouse.click(tiles["x"] + 0.45 * tiles["width"], tiles["y"] + 0.5 * tiles["height"])
    page.mouse.move(curves["x"] + 300, curves["y"] + 120)
    page.mouse.down()
    page.mouse.move(curves["x"] + 500, curves["y"] + 120, steps=5)
    page.mouse.up()
    take(page, "look")
    page.keyboard.press("Escape")
    page.get_by_role("tab", name="Learn").click()
    page.get_by_role("button", name="Diagnose").click()
    page.get_by_text("Missing effect found").wait_for()
    page.locator(".q-expansion-item").first.click()
    take(page, "learn")
    page.get_by_label("Add Coulomb friction").click()
    page.locator("header").get_by_text("coulomb").wait_for()
    page.get_by_role("tab", name="Steps").click()
    take(page, "steps")
    page.get_by_role("tab", name="Play").click()
    page.get_by_label("Light or dark").click()
    take(page, "dark")
    page.set_viewport_size(PHONE)
    take(page, "phone")


def main():
    """Take all of them."""
    from playwright.sync_api import sync_playwright

    browser = shutil.which("chromium") or shutil.which("google-chrome")
    if browser is None:
        sys.exit("page_pictures: expected Chromium or Chrome, found neither")
    PICTURES.mkdir(exist_ok=True)
    with (
        tempfile.TemporaryDirectory() as folder,
        served(Path(folder)) as address,
        sync_playwright() as started,
    ):
        page = started.chromium.launch(executable_path=browser, args=["--no-sandbox"]).new_page(
            viewport=WIDE
        )
        page.set_default_timeout(PATIENCE)
        page.goto(address)
        walk(page)
    print(f"{len([*PICTURES.glob('open_*.webp')])} pictures: {PICTURES}")


if __name__ == "__main__":
    main()

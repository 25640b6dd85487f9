"""The pictures of docs/open.md: `./er exec python -m test.page_pictures [live]`, in the system's browser.

Needs Chromium and the package playwright, as the tests of the page do.
"""

import io
import shutil
import signal
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from er_models.files import save_model
from PIL import Image

from test.conftest import ROOT
from test.played_graph import VEHICLE, with_friction
from test.sample import write_sample

PICTURES = ROOT / "docs" / "pictures"
WIDE, PHONE = {"width": 1280, "height": 800}, {"width": 390, "height": 844}
LIVE, FRAME, COLOURS = {"width": 1180, "height": 1010}, (826, 707), 64
"""Of the picture that moves: the page, what it is made smaller to, and its colours."""
PACE = 900
"""Between two of its frames [ms]."""
PATIENCE = 600_000.0
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


def columns(page, folder):
    """A file of a foreign rig, of which the page asks what its columns are."""
    own = folder / "Kolben.csv"
    rows = write_sample(own, seed=2, seconds=9.0).read_text(encoding="utf-8").splitlines()[1:]
    cells = [list(map(float, row.split(","))) for row in rows]
    lines = (f"{1e3 * t:.0f},{1e3 * x:.5f},{2.0 * u:.2f},{-F:.4f}" for t, x, _, u, F, *_ in cells)
    own.write_text("\n".join(["Zeit,Weg,Strom [A],CH3", *lines]), encoding="utf-8")
    page.get_by_role("tab", name="Data").click()
    page.set_input_files("input[type=file]", own)
    page.get_by_role("button", name="perhaps Weg").click()
    page.get_by_text("reads as 9 s").wait_for()
    page.mouse.move(0, 0)
    take(page, "columns")
    page.get_by_role("button", name="Cancel").click()
    page.get_by_role("tab", name="Play").click()


def walk(page):
    """Look, play, learn, add: a picture of each."""
    page.locator("header").get_by_text("held out").wait_for()
    with tempfile.TemporaryDirectory() as folder:
        columns(page, Path(folder))
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


@contextmanager
def driven():
    """The address of a page beside a played graph."""
    command = [sys.executable, "-m", "test.played_graph", "25", "1", "1"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        yield process.stdout.readline().strip()
        process.send_signal(signal.SIGINT)


def drive(page):
    """Beside a graph: a model that has the friction goes to the monitor, and the live error falls."""
    frames = []

    def look(times):
        for _ in range(times):
            page.wait_for_timeout(PACE)
            shot = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
            frames.append(shot.resize(FRAME, Image.LANCZOS))

    page.set_viewport_size(LIVE)
    page.get_by_text(": explains").wait_for()
    look(4)
    with tempfile.TemporaryDirectory() as folder:
        better = Path(folder) / "with_friction.yaml"
        save_model(replace(with_friction(VEHICLE), name="with_friction"), better)
        page.get_by_role("tab", name="Data").click()
        page.set_input_files("input[type=file]", better)
        page.locator("header").get_by_text("with_friction").wait_for()
        page.get_by_role("tab", name="Live").click()
        look(1)
        page.get_by_role("button", name="Monitor: use this model").click()
        page.mouse.move(0, 0)  # its words would stand before the switches
        page.get_by_text("monitor, with_friction_learnt_1").wait_for()
    look(8)
    moving(frames)
    page.set_viewport_size(WIDE | {"height": 1000})
    take(page, "live")
    page.get_by_label("Light or dark").click()
    page.mouse.move(0, 0)
    take(page, "live_dark")


def moving(frames):
    """One picture that moves, of the few colours that a page has; the last frame stays."""
    both = Image.new("RGB", (FRAME[0], 2 * FRAME[1]))
    for n, frame in enumerate((frames[0], frames[-1])):
        both.paste(frame, (0, n * FRAME[1]))
    palette = both.quantize(COLOURS, dither=Image.Dither.NONE)
    each = [f.quantize(palette=palette, dither=Image.Dither.NONE) for f in frames]
    times = [600] * (len(each) - 1) + [3000]
    path = PICTURES / "live.gif"
    each[0].save(
        path, save_all=True, append_images=each[1:], duration=times, loop=0, optimize=True
    )
    print(f"{len(each)} frames, {path.stat().st_size / 1e3:.0f} kB: {path}")


def main():
    """Take all of them, or those beside a graph (`live`)."""
    from playwright.sync_api import sync_playwright

    browser = shutil.which("chromium") or shutil.which("google-chrome")
    if browser is None:
        sys.exit("page_pictures: expected Chromium or Chrome, found neither")
    PICTURES.mkdir(exist_ok=True)
    with (
        tempfile.TemporaryDirectory() as folder,
        sync_playwright() as started,
        started.chromium.launch(executable_path=browser, args=["--no-sandbox"]) as window,
    ):
        parts = ((driven(), drive), (served(Path(folder)), walk))
        for address, walked in parts[:1] if "live" in sys.argv else parts:
            with address as there:
                page = window.new_page(viewport=WIDE)
                page.set_default_timeout(PATIENCE)
                page.goto(there)
                walked(page)
    print(f"{len([*PICTURES.glob('open_*.webp')])} pictures: {PICTURES}")


if __name__ == "__main__":
    main()

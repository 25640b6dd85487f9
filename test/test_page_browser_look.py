"""The page in a browser, at length: findings in the curves, held out by dragging, and a person's whole way."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from er_records.write import write_csv

import er_model_lab as lab
from test.page_help import PATIENCE, seen
from test.sample import write_sample

PLOT = ".js-plotly-plot"
STYLED = """() => {
  window.styled = [];
  const seen = new MutationObserver((all) => all.forEach((one) => window.styled.push(one.target.nodeName)));
  for (const each of [document.body, ...document.querySelectorAll("meta")]) seen.observe(each, {attributes: true});
}"""
"""Notes what would have a browser style every element anew."""
WORST_TILE = """e => {
  const {x, y, z} = e.data[0], {xaxis, yaxis} = e._fullLayout;
  const box = e.querySelector('.nsewdrag').getBoundingClientRect();
  const each = [...y].flatMap((_, i) => [...x].map((_, j) => [z[i][j] ?? -1, i, j]));
  const [, i, j] = each.reduce((a, b) => (b[0] > a[0] ? b : a));
  return [box.x + xaxis.d2p(x[j]), box.y + yaxis.d2p(y[i])];
}"""
"""Where on the screen the middle of the worst tile of a map is."""


def spoilt(folder: Path) -> Path:
    """Measurements whose load cell stands still for 0.4 s."""
    first = lab.load(write_sample(folder / "sound.csv", seed=1, seconds=9.0)).records[0]
    y = first.channels["damper_force"].copy()
    y[1000:1080] = 0.66 * y.max()
    channels = {**first.channels, "damper_force": y}
    write_csv(replace(first, channels=channels), folder / "spoilt.csv")
    return folder / "spoilt.csv"


def drag(page: Any, begin: float, end: float) -> None:
    """Drag over the curves between two shares of their width."""
    box = page.locator(f"{PLOT} .nsewdrag").first.bounding_box()
    y = box["y"] + 0.5 * box["height"]
    page.mouse.move(box["x"] + begin * box["width"], y)
    page.mouse.down()
    page.mouse.move(box["x"] + end * box["width"], y, steps=6)
    page.mouse.up()


def in_view(page: Any) -> list[float]:
    """The seconds that the curves show."""
    found: list[float] = page.locator(PLOT).first.evaluate("e => e.layout.xaxis.range")
    return found


@pytest.mark.slow
def test_findings_lie_in_the_curves_and_dragging_holds_out(tmp_path: Path) -> None:
    from playwright.sync_api import expect

    expect.set_options(timeout=PATIENCE)
    with seen(str(spoilt(tmp_path)), "--model", "inove_guo", cwd=tmp_path) as page:
        said = page.locator("header [role=status]")
        expect(said).to_contain_text("held out")
        page.get_by_role("tab", name="Data").click()
        page.get_by_role("button", name="warning: damper force of sound").click()
        page.wait_for_function(
            f"document.querySelector('{PLOT}').layout.xaxis.range[0] > 4", timeout=PATIENCE
        )
        low, high = in_view(page)
        assert 4.4 < low < 5.0 < 5.395 < high < 6.0
        page.keyboard.press("Escape")
        page.wait_for_function(f"document.querySelector('{PLOT}').layout.xaxis.range[0] < 1")

        page.get_by_role("switch", name="dragging holds out").click()
        page.wait_for_function(f"document.querySelector('{PLOT}').layout.dragmode == 'select'")
        drag(page, 0.7, 0.9)
        held = page.get_by_text("held out: sound")
        expect(held).to_contain_text(re.compile(r"6\.[23]\d? to 8\.[01]"))
        expect(said).to_contain_text("learnt from")
        page.wait_for_function(f"document.querySelector('{PLOT}').layout.xaxis.range")
        assert in_view(page)[0] < 1.0, "held out, not looked at"
        page.get_by_label("Undo").click()
        expect(held).to_have_count(0)

        page.get_by_text("Worst places").focus()
        help_of = "getComputedStyle(document.activeElement, '::after').content"
        assert "squared error" in page.evaluate(help_of), "help on a word, by the keyboard"
        page.set_viewport_size({"width": 390, "height": 844})
        for name in ("Data", "Play", "Learn", "Steps", "Take"):
            page.get_by_role("tab", name=name).click()
            page.wait_for_timeout(500)
            wide = page.evaluate("document.documentElement.scrollWidth")
            assert wide <= 390, f"{name} is wider than a phone"


@pytest.mark.slow
def test_what_a_browser_has_drawn_is_not_sent_again(tmp_path: Path) -> None:
    """The curves come with the page, the other plots once they are drawn; then nothing until something changes."""
    data, frames = write_sample(tmp_path / "run.csv", seed=1, seconds=9.0), list[str]()
    with seen(str(data), "--model", "inove_guo", cwd=tmp_path) as page:
        four = f"document.querySelectorAll('{PLOT} .main-svg').length >= 8"
        page.wait_for_function(four)
        page.on("websocket", lambda ws: ws.on("framereceived", lambda f: frames.append(str(f))))
        page.reload()
        page.wait_for_function(four)
        page.wait_for_timeout(1500)
        assert [sum(f.count(kind) for f in frames) for kind in ('"heatmap"', "N/√Hz")] == [1, 1]
        assert not any("measured − model" in f for f in frames), "the curves are in the page"
        page.evaluate(STYLED)
        page.locator('[data-parameter="passive.c0"] [tabindex="0"]').press("ArrowRight")
        page.wait_for_timeout(1500)
        assert any("measured − model" in f for f in frames)
        assert page.evaluate("window.styled") == [], "the whole page is not styled anew"


@pytest.mark.slow
def test_a_person_goes_the_whole_way(tmp_path: Path) -> None:
    from playwright.sync_api import expect

    expect.set_options(timeout=PATIENCE)
    own = write_sample(tmp_path / "Messung.csv", seed=1, seconds=9.0)
    head = "Zeit [s],Weg [m],Geschwindigkeit [m/s],u,Kraft [N],a1,a2"
    own.write_text("\n".join([head, *own.read_text("utf-8").splitlines()[1:]]), encoding="utf-8")
    with seen("--model", "inove_guo", cwd=tmp_path) as page:
        said = page.locator("header [role=status]").first
        page.set_input_files("input[type=file]", own)
        page.get_by_role("button", name="Use").click()
        expect(said).to_contain_text("held out")
        look(page)
        drag_a_slider(page, said)
        diagnose(page)
        add_and_take_back(page, said)
        program, model = take(page, tmp_path, "Program"), take(page, tmp_path, "Model")
    assert "    Messung.csv" in program.read_text("utf-8")
    done = subprocess.run(
        [sys.executable, program], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("error ")
    made, taken = (lab.load_model(path) for path in (tmp_path / "model.yaml", model))
    assert made.digest() == taken.digest()
    assert "coulomb_friction" in made.effects


def look(page: Any) -> None:
    """Click a tile of the map, then a worst place."""
    page.wait_for_function(
        f"[...document.querySelectorAll('{PLOT}')].every(p => p.data.length > 0)"
    )
    page.wait_for_timeout(500)
    page.mouse.click(*page.locator(PLOT).nth(1).evaluate(WORST_TILE))
    page.wait_for_function(
        f"document.querySelector('{PLOT}').data.some(d => d.name == 'in the tile')"
    )
    page.keyboard.press("Escape")
    page.get_by_role("button", name=re.compile(r"%: [0-9.]+ to [0-9.]+ s$")).first.click()
    page.wait_for_function(
        f"(r => r[1] - r[0] < 2)(document.querySelector('{PLOT}').layout.xaxis.range)"
    )
    page.keyboard.press("Escape")


def drag_a_slider(page: Any, said: Any) -> None:
    """With the mouse: the error follows, one step of undo takes it back; beside it the model of before."""
    page.get_by_role("tab", name="Play").click()
    first = said.inner_text()
    box = page.locator('[data-parameter="passive.c0"]').bounding_box()
    thumb = page.locator('[data-parameter="passive.c0"] .q-slider__thumb').bounding_box()
    y = thumb["y"] + 0.5 * thumb["height"]
    page.mouse.move(thumb["x"] + 0.5 * thumb["width"], y)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.9 * box["width"], y, steps=8)
    page.mouse.up()
    expect_other(page, said, first)
    page.get_by_role("combobox", name="Lay another model beside").click()
    page.get_by_role("option", name="model inove guo").click()
    page.get_by_text(f"beside: {first.removeprefix('error ')}").wait_for()
    page.get_by_label("Undo").click()
    page.wait_for_function(
        "t => document.querySelector('header [role=status]').innerText == t", arg=first
    )


def expect_other(page: Any, said: Any, text: str) -> None:
    """The page says something else than it did."""
    page.wait_for_function(
        "t => document.querySelector('header [role=status]').innerText != t", arg=text
    )


def diagnose(page: Any) -> None:
    """To the end, with those ahead as they are judged; then a second one that is cancelled."""
    page.get_by_role("tab", name="Learn").click()
    button = page.get_by_role("button", name="Diagnose")
    button.click()
    page.get_by_text(re.compile(r"^1\. .+: [0-9.]+ N")).first.wait_for()
    page.get_by_text("Missing effect found").wait_for()
    card = page.locator(".q-expansion-item").first
    card.click()
    card.locator("math").first.wait_for()
    card.get_by_role("button", name=re.compile("Plan the run that tells it from")).first.wait_for()
    button.click()
    page.get_by_role("button", name="Cancel").click()
    page.get_by_text("cancelled").first.wait_for()


def add_and_take_back(page: Any, said: Any) -> None:
    """The effect is added, undone, done again, and taken back with the rest refitted."""
    before = said.inner_text()
    page.get_by_label("Effect to add").fill("coulomb")
    page.get_by_role("option", name="Coulomb friction").click()
    page.get_by_role("button", name="Add", exact=True).click()
    page.locator("header").get_by_text("inove_guo_coulomb_friction").wait_for()
    after = said.inner_text()
    page.get_by_label("Undo").click()
    page.wait_for_function(
        "t => document.querySelector('header [role=status]').innerText == t", arg=before
    )
    page.get_by_label("Redo").click()
    page.get_by_role("tab", name="Steps").click()
    page.get_by_label("Take back coulomb friction").click()
    page.locator("header").get_by_text("inove_guo_coulomb_friction_refitted").wait_for()
    expect_other(page, said, after)
    page.get_by_label("Undo").click()
    page.wait_for_function(
        "t => document.querySelector('header [role=status]').innerText == t", arg=after
    )


def take(page: Any, folder: Path, name: str) -> Path:
    """Something of the session as a file."""
    page.get_by_role("tab", name="Take").click()
    with page.expect_download() as download:
        page.get_by_role("button", name=name, exact=True).click()
    path: Path = folder / f"taken_{download.value.suggested_filename}"
    download.value.save_as(path)
    return path


@pytest.mark.slow
def test_ten_tabs_show_one_session_and_cost_little(tmp_path: Path) -> None:
    data = write_sample(tmp_path / "run.csv", seed=1, seconds=9.0)
    with seen(str(data), "--model", "inove_guo", cwd=tmp_path) as page:
        said = "document.querySelector('header [role=status]').innerText"
        page.wait_for_function(f"{said}.includes('held out')")
        tabs = [page.context.new_page() for _ in range(10)]
        before = served_memory()
        for tab in tabs:
            tab.goto(page.url, timeout=PATIENCE)
            tab.wait_for_function(f"{said}.includes('held out')", timeout=PATIENCE)
        assert (served_memory() - before) / len(tabs) < 15.0
        first = page.evaluate(said)
        page.get_by_role("tab", name="Play").click()
        page.locator('[data-parameter="passive.c0"] [tabindex="0"]').press("ArrowRight")
        for tab in tabs:
            tab.wait_for_function(f"t => {said} != t", arg=first, timeout=PATIENCE)
            assert tab.evaluate(said) == tabs[0].evaluate(said)


def served_memory() -> float:
    """What the page that this test started holds [MB]."""
    children = Path(f"/proc/self/task/{os.getpid()}/children").read_text("ascii").split()
    (page,) = (
        c for c in children if b"er_model_lab.cli.app" in Path(f"/proc/{c}/cmdline").read_bytes()
    )
    found = re.search(r"VmRSS:\s+(\d+)", Path(f"/proc/{page}/status").read_text("ascii"))
    return int(found[1]) / 1e3 if found else 0.0

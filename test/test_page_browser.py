"""`lab open` as a program: its address, what it refuses, and a person's way through the page in a browser."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import er_model_lab as lab
from test.page_help import PATIENCE, PLAYED, opened, seen, status
from test.sample import write_sample


def test_only_the_address_that_is_printed_opens_the_page(tmp_path: Path) -> None:
    with opened(cwd=tmp_path) as address:
        place, token = address.removeprefix("http://127.0.0.1:").split("/?token=")
        port = int(place)
        cookie = f"er_lab_{port}={token}"
        assert status(port, f"/?token={token}") == 303
        assert {status(port, "/", Cookie=cookie) for _ in range(10)} == {200}, "ten tabs"
        assert status(port, "/") == status(port, f"/?token={token[:-1]}") == 403
        assert status(port, "/_nicegui_ws/socket.io/?EIO=4&transport=polling") == 403
        assert status(port, "/", Cookie=cookie, Origin="http://evil.example") == 403
        assert status(port, "/", Cookie=cookie, Host="evil.example") == 421
        assert status(port, "/", Cookie=cookie, Content_Length=str(2 << 30)) == 413
        for path in (
            "/../../etc/passwd",
            "/_nicegui/../../etc/passwd",
            "/%2e%2e/etc/passwd",
            "/docs",
            "/openapi.json",
        ):
            assert status(port, path, Cookie=cookie) == 404
        busy = subprocess.run(
            [sys.executable, "-m", "er_model_lab.cli.app", "open", "--port", place], capture_output=True, text=True,
            check=False,
        )  # fmt: skip
        assert busy.returncode == 2
        assert busy.stderr.startswith("--port: expected a port that is free")


@pytest.fixture
def page(tmp_path: Path) -> Iterator[Any]:
    """A page over a model."""
    with seen("--model", "inove_guo", cwd=tmp_path) as made:
        yield made


def test_drop_look_drag_cancel_add_undo_and_take(page: Any, tmp_path: Path) -> None:
    from playwright.sync_api import expect

    expect.set_options(timeout=PATIENCE)
    said = page.locator("header [role=status]")
    own = tmp_path / "Messung.csv"
    text = write_sample(own, seed=1, seconds=9.0).read_text(encoding="utf-8")
    head = "Zeit [s],Weg [m],Geschwindigkeit [m/s],u,Kraft [N],a1,a2"
    own.write_text("\n".join([head, *text.splitlines()[1:]]), encoding="utf-8")
    page.set_input_files("input[type=file]", own)
    page.get_by_role("button", name="Use").click()
    expect(said).to_contain_text("held out")

    page.get_by_role("tab", name="Play").click()
    first = said.inner_text()
    slider = page.locator('[data-parameter="passive.c0"] [tabindex="0"]')
    slider.press("ArrowRight")
    expect(said).not_to_have_text(first)
    page.get_by_label("Undo").click()
    expect(said).to_have_text(first)

    page.get_by_role("tab", name="Learn").click()
    page.get_by_role("button", name="Diagnose").click()
    page.get_by_role("button", name="Cancel").click()
    expect(page.get_by_role("button", name="Diagnose")).to_be_enabled()
    page.get_by_label("Effect to add").fill("coulomb")
    page.get_by_role("option", name="Coulomb friction").click()
    page.get_by_role("button", name="Add", exact=True).click()
    expect(page.locator("header")).to_contain_text("inove_guo_coulomb_friction")
    page.get_by_label("Undo").click()
    expect(said).to_have_text(first)
    page.get_by_label("Redo").click()
    expect(said).not_to_have_text(first)

    page.get_by_role("tab", name="Take").click()
    taken = {}
    for name in ("Program", "Model", "Session"):
        with page.expect_download() as download:
            page.get_by_role("button", name=name, exact=True).click()
        taken[name] = tmp_path / download.value.suggested_filename
        download.value.save_as(taken[name])
    shutil.unpack_archive(taken["Session"], tmp_path / "again")
    assert (tmp_path / "again/data/Messung.csv").read_bytes() == own.read_bytes()
    program = (tmp_path / "again/session.py").read_text(encoding="utf-8")
    assert "lab.load('data/Messung.csv', names={'t': 'Zeit'" in program
    assert "lab.add(data, model, 'coulomb_friction', seed=SEED" in program
    assert "coulomb_friction" in lab.load_model(taken["Model"]).effects
    assert "lab.add(data" in taken["Program"].read_text(encoding="utf-8")


def test_columns_of_a_foreign_rig_are_told_once_and_a_new_model_is_scaled_to_them(
    tmp_path: Path,
) -> None:
    """Names and units that say nothing, in two files, one of them turned by hand: no terminal is needed."""
    from playwright.sync_api import expect

    expect.set_options(timeout=PATIENCE)
    files = [tmp_path / f"ring{k}.csv" for k in (1, 2)]
    for k, own in enumerate(files):
        rows = write_sample(own, seed=k, seconds=9.0).read_text(encoding="utf-8").splitlines()[1:]
        cells = [list(map(float, row.split(","))) for row in rows]
        lines = (f"{1e3 * t:.0f},{1e3 * x:.9f},{-F:.9f}" for t, x, _, _, F, *_ in cells)
        own.write_text("\n".join(["ch1,ch2,ch3", *lines]), encoding="utf-8")
    with seen(cwd=tmp_path) as page:
        page.get_by_text("No data yet").wait_for()
        late = list[Any]()
        page.route("**/upload/*", lambda held: late.append(held), times=1)
        with page.expect_response("**/upload/*"):
            page.set_input_files("input[type=file]", files)
        late[0].continue_()  # the first file arrives last, and is asked about first
        asked = page.locator(".q-dialog")
        state, use = asked.get_by_role("status"), asked.get_by_role("button", name="Use")

        def choose(label: str, option: str, k: int = 0) -> None:
            asked.get_by_role("combobox", name=label, exact=True).nth(k).click()
            page.get_by_role("option", name=option, exact=True).click()

        expect(state).to_have_text("no column is known yet")
        choose("deflection", "ch2")
        expect(state).to_have_text("deflection: no unit, and too large for SI")
        expect(use).to_be_disabled()
        choose("unit", "mm", 1)
        expect(state).to_have_text("reads as 9 s of measurements")
        expect(
            asked.get_by_text("ms", exact=True)
        ).to_be_visible()  # as seconds it would step by 5
        choose("damper_force", "ch3")
        times = asked.get_by_role("textbox", name="times").last
        times.fill("2x")
        expect(state).to_have_text("damper_force: no number")
        expect(use).to_be_disabled()
        times.fill("")
        expect(state).to_have_text("reads as 9 s of measurements")
        choose("One more channel", "temperature")
        choose("temperature", "ch1")
        choose("temperature", "(none)")
        choose("duty", "(constant)")
        expect(state).to_have_text("duty: a number")
        constant = asked.get_by_role("textbox", name="0 ... 1")
        constant.fill("0, 0.3")
        expect(state).to_contain_text("duty.value: expected 1 value, one for each part")
        constant.fill("0")
        expect(state).to_have_text("reads as 9 s of measurements")
        expect(asked.get_by_role("checkbox").nth(3)).to_be_checked()
        use.click()
        expect(
            page.get_by_text("ring2.csv: read as the file before with these columns")
        ).to_be_visible()
        page.get_by_text("Begin with a model under Data").wait_for()
        page.get_by_text("ring2, 8.995 s").wait_for()
        page.wait_for_timeout(500)
        page.set_input_files("input[type=file]", files[0])  # later: an answer may be mended
        asked.get_by_role("button", name="Cancel").click()
        expect(page.get_by_text(re.compile(r"^ring1\S*: left out$"))).to_be_visible()
        page.get_by_role("combobox", name="New model, scaled to the data").click()
        page.get_by_role("option", name="friction: ").click()
        expect(page.locator("header")).to_contain_text("start_friction")
        expect(page.locator("header [role=status]")).to_contain_text("held out")
        page.get_by_role("tab", name="Take").click()
        with page.expect_download() as download:
            page.get_by_role("button", name="Program", exact=True).click()
        program = Path(download.value.path()).read_text(encoding="utf-8")
    assert "lab.new(data, 'friction'" in program
    assert program.count("'damper_force': {'from': 'ch3', 'sign': -1}") == 3


@pytest.mark.slow
def test_beside_a_running_graph_the_live_error_falls_once_the_effect_is_added(
    tmp_path: Path,
) -> None:
    from playwright.sync_api import expect

    expect.set_options(timeout=PATIENCE)
    with seen("14", "1", "0.2", cwd=tmp_path, program=PLAYED) as page:
        expect(page.get_by_text("monitor, inove_quarter_car: explains")).to_be_visible()
        expect(page.get_by_text("drive a bump").first).to_be_visible()
        before = live_error(page)
        page.get_by_role("tab", name="Learn").click()
        page.get_by_label("Effect to add").fill("coulomb")
        page.get_by_role("option", name="Coulomb friction").click()
        page.get_by_role("button", name="Add", exact=True).click()
        page.get_by_role("tab", name="Live").click()
        expect(
            page.get_by_text("monitor, inove_quarter_car_coulomb_friction_learnt_1")
        ).to_be_visible()
        page.wait_for_function(
            "([text, most]) => parseFloat((document.body.innerText.match(text) || [0, 9])[1]) < most",
            arg=[LIVE, 0.6 * before],
        )
        page.get_by_role("switch", name="follow the drive").click()
        expect(page.locator("header [role=status]")).to_contain_text("held out")


@pytest.mark.slow
def test_axe_finds_nothing_serious_on_any_panel_light_or_dark(tmp_path: Path) -> None:
    axe = pytest.importorskip(
        "axe_playwright_python.sync_playwright", reason="axe is not installed"
    ).Axe()
    found = dict[str, list[str]]()
    with seen("12", "0", "0", cwd=tmp_path, program=PLAYED) as page:
        page.get_by_text("To drive next").wait_for()
        for name in ("Live", "Data", "Play", "Learn", "Steps", "Take", "Live again, dark"):
            if name.endswith("dark"):
                page.get_by_label("Light or dark").click()
            page.get_by_role("tab", name=name.split()[0]).click()
            page.wait_for_timeout(700)
            found[name] = [
                f"{v['id']}: {v['nodes'][0]['html'][:120]}"
                for v in axe.run(page).response["violations"]
                if v["impact"] in ("serious", "critical")
            ]
    assert {name: each for name, each in found.items() if each} == {}


LIVE = r"live error ([0-9.]+) N"
"""What the page says of the monitor's error."""


def live_error(page: Any) -> float:
    """The error that a live page shows [N]."""
    found = page.get_by_text(re.compile(LIVE)).inner_text()
    return float(re.search(LIVE, found)[1])  # type: ignore[index]

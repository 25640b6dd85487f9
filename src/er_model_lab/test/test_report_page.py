"""The page: opens offline, holds what there is and nothing else, and never harms an earlier report."""

from __future__ import annotations

import base64
import gzip
import io
import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from er_model_lab.cli.options import in_options
from er_model_lab.output.report import page as page_module
from er_model_lab.output.report.effects import write_cards
from er_model_lab.output.report.order import SECTIONS
from er_model_lab.output.report.page import figures, render, write_report
from er_model_lab.view import View
from er_models.cards.equation import equations
from er_models.catalogue import CATALOGUE
from er_models.errors import InputError
from PIL import Image
from report_views import (
    FUSION,
    HISTORY,
    IDENTIFIED,
    MODELS,
    PLANNED,
    PREFLIGHT,
    compared,
    empty,
    program,
    view,
)

VOID = {"meta", "img", "br", "link", "input", "hr"}
LOADING = {"src", "href", "srcset", "action", "data", "poster", "formaction"}


def _stub() -> bytes:
    """A small picture in place of a figure, where the page around it is tested."""
    out = io.BytesIO()
    Image.new("RGB", (2, 2)).save(out, "PNG")
    return out.getvalue()


STUB = _stub()


class Page(HTMLParser):
    """Sections, links, pictures, scripts, and whether every tag is closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.raw = text
        self.stack: list[str] = []
        self.ids: list[str] = []
        self.loads: list[str] = []
        self.alts: dict[str, str] = {}
        self.plots: list[str] = []
        self.scripts: dict[str, str] = {}
        self.script = ""
        self.text = ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        known = {k: v or "" for k, v in attrs}
        self.loads += [v for k, v in known.items() if k in LOADING]
        self.ids += [known["id"]] if "id" in known else []
        self.plots += [known["data-plot"]] if "data-plot" in known else []
        if tag == "img":
            self.alts[known["src"][:200]] = known.get("alt", "")
        if tag not in VOID:
            self.stack.append(tag)
        self.script = known.get("id", "inline") if tag == "script" else ""

    def handle_endtag(self, tag: str) -> None:
        assert self.stack, f"</{tag}> closes nothing"
        assert self.stack.pop() == tag, f"</{tag}> closes another tag"
        self.script = ""

    def handle_data(self, data: str) -> None:
        if self.script:
            self.scripts[self.script] = self.scripts.get(self.script, "") + data
        else:
            self.text += " " + data


def rendered(v: View) -> Page:
    """The page of a view without drawing its pictures."""
    sections = [s for make in SECTIONS if (s := make(v)) is not None]
    return Page(render(v, sections, {f.name: (STUB, b"<svg/>") for f in figures(v)}))


def sections_of(v: View) -> set[str]:
    """Keys of the sections that are on the page."""
    keys = {make.__module__.rsplit(".", 1)[1] for make in SECTIONS}
    return keys & set(rendered(v).ids)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report of ten minutes at 200 Hz."""
    return write_report(view(seconds=300.0), tmp_path_factory.mktemp("report") / "deep" / "er")


@pytest.mark.slow
def test_ten_minutes_of_data_stay_under_five_megabytes(written: Path) -> None:
    assert written.name == "index.html"
    assert 1_500_000 < written.stat().st_size < 5_000_000


def test_the_page_is_well_formed_and_loads_nothing(written: Path) -> None:
    text = written.read_text(encoding="utf-8")
    page = Page(text)
    assert page.stack == []
    assert len(page.ids) == len(set(page.ids))
    assert all(v.startswith(("#", "data:image/")) for v in page.loads)
    assert {v[1:] for v in page.loads if v.startswith("#")} <= set(page.ids), (
        "no link leads nowhere"
    )
    outside = re.sub(r"base64,[\w+/=]+", "", text)
    assert not re.search(
        r"https?://|@import|url\(|//cdn", outside.replace("http://www.w3.org", "")
    )
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', text)
    assert policy
    assert "default-src 'none'" in policy.group(1)
    assert "http" not in policy.group(1)


def test_every_picture_has_words(written: Path) -> None:
    page = Page(written.read_text(encoding="utf-8"))
    assert len(page.alts) > 8
    assert all(len(alt) > 25 for alt in page.alts.values())


def test_the_plots_in_the_page_are_complete(written: Path) -> None:
    page = Page(written.read_text(encoding="utf-8"))
    plots = json.loads(gzip.decompress(base64.b64decode(page.scripts["er-plots"])))
    assert [p["name"] for p in plots] == page.plots
    assert len(plots) >= 7
    (series,) = [p for p in plots if p["name"] == "time_series"]
    assert len(series["packed"][0]["rises"]) > 120_000, (
        "ten minutes can be looked at sample by sample"
    )
    library = gzip.decompress(base64.b64decode(page.scripts["er-library"])).decode()
    assert "plotly.js" in library[:300]
    assert 'plotlyServerURL: ""' in page.scripts["inline"], "no button may upload measurements"


@pytest.mark.slow
def test_every_figure_is_a_picture_on_disk(written: Path) -> None:
    names = {f.name for f in figures(view(seconds=300.0))}
    files = {p.name for p in (written.parent / "figures").iterdir()}
    assert files == {f"{n}.{kind}" for n in names for kind in ("png", "svg")}
    for name in names:
        with Image.open(written.parent / "figures" / f"{name}.png") as image:
            grey = np.asarray(image.convert("L"))
        assert min(grey.shape) > 300, name
        assert grey.std() > 8.0, f"{name} is blank"
        ElementTree.parse(written.parent / "figures" / f"{name}.svg")


TERM = {
    "name": "measured_velocity", "quantities": ["velocity"], "times": "", "shape": ["odd"],
    "rmse_held_out": {"before": 0.3, "after": 0.15}, "looks_like": [{"effect": "coulomb_friction", "share": 0.9}],
    "formula": {"text": "v |x|", "share": 0.8, "share_of_term": 0.9}, "effect_source": "",
    "drawn": {"edges": {"velocity": [-0.1, 0.0, 0.1]}, "force": [-1.0, 1.0]},
}  # fmt: skip
"""A measured term as `improve` tells it."""


def test_all_sections_appear_with_their_data() -> None:
    rest = {
        "depends_on": {"deflection": 0.3},
        "share": 0.4,
        "line": {"frequency": 50.0, "amplitude": 0.3, "share": 0.2},
    }
    groups = [["coulomb_friction", "shear_thinning"]]
    full = view(
        alternatives=groups,
        unexplained=rest,
        preflight=PREFLIGHT,
        history=HISTORY,
        fusion=FUSION,
        models=MODELS,
        measured_terms=[TERM],
        **IDENTIFIED,
        **PLANNED,
    )
    assert sections_of(full) == {make.__module__.rsplit(".", 1)[1] for make in SECTIONS}


def test_a_planned_program_is_drawn_with_the_forces_of_both_truths() -> None:
    base = view(verdict="told_apart", **PLANNED)
    shown = [program(name, base.records[0]) for name in ("program 1", "identification")]
    v = replace(base, command="plan", records=(), regions=(), programs=tuple(shown))
    drawn = {f.name: f for f in figures(v)}
    assert {"planned_program", "planned_forces", "everyday_program", "everyday_forces"} <= set(
        drawn
    )
    titles = [p.title for p in drawn["planned_forces"].panels]
    assert "Shear thinning, imitated by Coulomb friction" in titles
    page = rendered(v)
    assert "imitation leaves is 2 times" in page.text
    assert "10 of 10" in page.text


@pytest.mark.parametrize(
    ("change", "gone"),
    [
        (lambda v: replace(v, records=()), {"time_series", "loops", "residual_maps", "spectrum"}),
        (lambda v: replace(v, regions=()), {"where_it_fails"}),
        (lambda v: replace(v, candidates=()), {"cards"}),
        (lambda v: replace(v, result={**v.result, "candidates": []}), {"candidates"}),
        (
            lambda v: replace(v, result={**v.result, "steps": v.result["steps"][:1]}),
            {"falling_error"},
        ),
        (
            lambda v: replace(v, result={k: x for k, x in v.result.items() if k != "rmse"}),
            {"summary"},
        ),
        (lambda v: replace(v, result={**v.result, "floors": {}}), {"noise"}),
        (lambda v: replace(v, result={**v.result, "parameters": {}}), {"identified"}),
        (lambda v: replace(v, notes=(), provenance={}), {"provenance"}),
        (lambda _: compared(), {"candidates", "cards", "falling_error", "identified"}),
    ],
)
def test_a_section_without_data_is_left_out(change, gone: set[str]) -> None:
    base = view()
    assert sections_of(base) - sections_of(change(base)) == gone


def test_a_view_with_nothing_but_a_headline_still_makes_a_page() -> None:
    page = rendered(empty())
    assert "unexplained 0.6 N" in page.text
    assert page.plots == []
    assert "er-library" not in page.scripts


def test_incomplete_data_are_said_and_no_link_leads_nowhere() -> None:
    for v in (view(complete=False), replace(empty(), result={"complete": False})):
        page = rendered(v)
        assert "The data were incomplete" in page.text
        assert {link[1:] for link in page.loads if link.startswith("#")} <= set(page.ids)
    assert "incomplete" not in rendered(view()).text


def test_the_page_shows_the_numbers_of_the_result() -> None:
    text = " ".join(rendered(view()).text.split())
    for words in (
        "Missing effect found: Coulomb friction", "unexplained 0.6 N, noise 0.2 N, model 0.566 N",
        "0.600 N",
        "0.936", "0.0088", "taken: lowers the error", "velocity derived from deflection", "seed",
        "record_1",
        "velocity 0 to 20 mm/s", "55 %",
        "./er lab diagnose DATA --model inove_guo.yaml --seed 7 --report DIR",
    ):  # fmt: skip
        assert words in text, words


def test_cards_typeset_the_equation_and_show_no_code(tmp_path: Path) -> None:
    effect = CATALOGUE["freeplay"]
    path = write_cards([effect], CATALOGUE, {}, tmp_path)
    for page in (rendered(view()).raw, path.read_text(encoding="utf-8")):
        formulas = [re.sub(r"\s+", "", f) for f in re.findall(r"<math.*?</math>", page, re.S)]
        assert formulas
        assert not re.search(r"def \w+\(|math\.tanh", page.partition("<script")[0])
    written = [e.mathml.replace(" ", "") for e in equations(effect)]
    assert formulas == [re.sub(r"\s+", "", f) for f in written], "a card is its hooks"


def test_what_no_record_can_show_is_said_with_its_reason() -> None:
    text = rendered(view()).text
    assert "Gain of the force channel" in text
    assert "because the damper's forces scale along." in text


def test_the_command_on_the_page_is_the_one_recorded() -> None:
    v = replace(view(), provenance={"command_line": "./er lab diagnose rig.csv --model m.yaml"})
    assert "./er lab diagnose rig.csv --model m.yaml" in rendered(v).text


def test_names_from_files_cannot_become_markup() -> None:
    v = view()
    evil = "<script>alert(1)</script>"
    v = replace(v, model=evil, notes=(evil,), records=(replace(v.records[0], name=evil),))
    page = rendered(v)
    assert set(page.scripts) == {"er-library", "er-plots", "inline"}
    assert "alert(1)" not in page.scripts["inline"]
    assert evil in page.text


def test_a_second_report_replaces_the_first_and_leaves_other_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(page_module, "still", lambda _: (STUB, b"<svg/>"))
    small = replace(view(seconds=6.0, records=1), candidates=(), regions=())
    write_report(small, tmp_path)
    (tmp_path / "figures" / "mine.png").write_bytes(b"mine")
    (tmp_path / "notes.txt").write_text("mine")
    write_report(replace(small, result={**small.result, "steps": []}), tmp_path)
    left = {p.name for p in (tmp_path / "figures").iterdir()}
    assert "falling_error.png" not in left, "a picture of another result would mislead"
    assert {"mine.png", "loops.png", "loops.svg"} <= left
    assert (tmp_path / "notes.txt").exists()
    assert not list(tmp_path.rglob("*.part"))


def test_nothing_is_overwritten_when_drawing_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "index.html").write_text("earlier")

    def broken(_: object) -> tuple[bytes, bytes]:
        raise RuntimeError("no pen")

    monkeypatch.setattr(page_module, "still", broken)
    with pytest.raises(RuntimeError, match="no pen"):
        write_report(compared(4.0), tmp_path)
    assert (tmp_path / "index.html").read_text() == "earlier"
    assert not (tmp_path / "figures").exists()


def test_a_folder_that_cannot_be_written_is_named_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError) as caught:
        write_report(replace(empty()), tmp_path / "file" / "report")
    assert ": report: expected a folder that can be written" in str(caught.value)
    assert ": --report: expected a folder that can be written" in in_options(caught.value)
    assert "\n" not in str(caught.value)

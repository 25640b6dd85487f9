"""One description, two drawings: every kind of mark is drawn by both, with the same numbers."""

from __future__ import annotations

import base64
import io
import typing
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from er_model_lab.output.report import live_marks, still_marks
from er_model_lab.output.report.embed import picture
from er_model_lab.output.report.figure import (
    Axis,
    Band,
    Bars,
    Figure,
    Label,
    Level,
    Line,
    Mark,
    Panel,
    Points,
    Scale,
    Spans,
    Tiles,
)
from er_model_lab.output.report.live import live
from er_model_lab.output.report.page import figures
from er_model_lab.output.report.palette import ERROR
from er_model_lab.output.report.samples import binned_mean, rms_map
from er_model_lab.output.report.sections import (
    candidates,
    cards,
    falling_error,
    residual_maps,
    spectrum,
    time_series,
)
from er_model_lab.output.report.still import still
from PIL import Image
from report_views import NOISE, card, compared, record, rms, view

X = np.linspace(0.0, 1.0, 40)


def everything() -> Figure:
    """A figure with every kind of mark."""
    marks = (
        Line(X, np.sin(9 * X), "line", "#0072b2", dash="dot"), Points(X, X, "dots", X),
        Bars(X[:3], X[:3], "bars", ("#d55e00",) * 3, ends=np.stack([X[:3] - 0.1, X[:3] + 0.2]),
        text=("a", "b", "c")),
        Band(-0.2, 0.2, "band", "#009e73"), Spans(((0.1, 0.2),), "span", "#f2e2a0"), Label(0.5,
        "here"),
        Level(0.3, "level", "#000000"), Level(0.4, "across", "#000000", vertical=True),
    )  # fmt: skip
    tiles = Tiles(
        np.linspace(0, 1, 4), np.linspace(0, 1, 3), np.array([[1.0, 2, np.nan], [4, 5, 6]])
    )
    panels = (Panel(marks, title="all"), Panel((tiles,)))
    return Figure("all", "all marks", panels, 2, scale=Scale("value", 0.0, 6.0, ERROR))


def test_both_renderers_draw_every_kind_of_mark() -> None:
    kinds = {type(m) for p in everything().panels for m in p.marks}
    assert kinds == set(typing.get_args(Mark)), "a mark that is listed must be tried here"
    for registry in (still_marks.draw.registry, live_marks.draw.registry):
        assert kinds <= set(registry)
    drawn = live(everything())
    assert {t["type"] for t in drawn["data"]} == {"scatter", "bar", "heatmap"}
    assert len(drawn["layout"]["shapes"]) == 4
    png, svg = still(everything())
    assert ElementTree.fromstring(svg).tag.endswith("svg")
    assert np.asarray(Image.open(io.BytesIO(png)).convert("L")).std() > 10.0


@pytest.mark.parametrize(
    "mark", [m for p in everything().panels for m in p.marks], ids=lambda m: type(m).__name__
)
def test_every_mark_can_be_seen_in_both_drawings(mark: Mark) -> None:
    axes = {"x": Axis(span=(0.0, 1.0)), "y": Axis(span=(-1.0, 2.0))}
    blank, drawn = (
        Figure(
            "one",
            "",
            (Panel(marks, **axes),),
            width=300,
            height=200,
            scale=Scale("value", 0.0, 6.0, ERROR),
        )
        for marks in ((), (mark,))
    )
    (blank_png, _), (png, svg) = still(blank), still(drawn)
    inner = (slice(45, 230), slice(60, 330))
    pixels = [
        np.asarray(Image.open(io.BytesIO(p)).convert("RGB"), float) for p in (blank_png, png)
    ]
    if pixels[0].shape == pixels[1].shape:
        assert np.abs(pixels[0] - pixels[1])[inner].max() > 15.0 or isinstance(mark, Label)
    assert b"here" in svg or not isinstance(mark, Label)
    assert live(blank) != live(drawn)


def test_what_is_no_mark_is_refused_by_both() -> None:
    figure = Figure("odd", "", (Panel(("not a mark",)),))  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="str is no mark"):
        live(figure)
    with pytest.raises(TypeError, match="str is no mark"):
        still(figure)


def test_the_same_figure_gives_the_same_files() -> None:
    assert still(everything()) == still(everything())


def test_the_picture_in_the_page_is_the_smaller_of_the_two() -> None:
    png, svg = still(everything())
    kind, _, data = picture(png, svg).partition(";base64,")
    assert kind in ("data:image/png", "data:image/svg+xml")
    assert len(base64.b64decode(data)) <= len(svg)
    assert picture(png, b"<svg/>").startswith("data:image/svg")


def test_every_mark_of_a_report_reaches_the_live_plot_with_its_numbers() -> None:
    for figure in [f for f in figures(view()) if f.interactive]:
        drawn = live(figure)
        traces = [
            m
            for p in figure.panels
            for m in p.marks
            if isinstance(m, Line | Points | Bars | Tiles)
        ]
        assert len(drawn["data"]) == len(traces), figure.name
        for mark, trace in zip(traces, drawn["data"], strict=True):
            if isinstance(mark, Line) and trace["y"]:
                np.testing.assert_allclose(
                    np.array(trace["y"], float), mark.y, rtol=1e-4, atol=1e-9
                )


def test_the_time_series_shows_the_residual_of_the_models_it_shows() -> None:
    v = view(records=1)
    section = time_series.section(v)
    assert section is not None
    (figure,) = section.figures
    force, residual = (
        {m.name: m for m in p.marks if isinstance(m, Line)} for p in figure.panels[:2]
    )
    for name in ("model before", "model after"):
        np.testing.assert_allclose(
            residual[name].y, force["measured"].y - force[name].y, atol=1e-12
        )
    (band,) = [m for m in figure.panels[1].marks if isinstance(m, Band)]
    assert (band.low, band.high) == (-2 * NOISE, 2 * NOISE)
    assert any(isinstance(m, Spans) for m in figure.panels[0].marks), "held-out data are shaded"
    low, high = figure.panels[0].x.span or (0.0, 0.0)
    assert high - low == pytest.approx(5.0, abs=0.02)


def test_a_comparison_shades_nothing_because_nothing_was_fitted() -> None:
    (figure,) = time_series.section(compared()).figures  # type: ignore[union-attr]
    assert not any(isinstance(m, Spans) for p in figure.panels for m in p.marks)


def test_long_series_travel_whole_and_are_drawn_thinned_in_the_picture() -> None:
    v = view(seconds=60.0, records=1)
    (figure,) = time_series.section(v).figures  # type: ignore[union-attr]
    drawn = live(figure)
    assert len(drawn["long"]) == 7
    assert len(drawn["packed"]) == 8, "one time axis for all curves"
    assert all(len(p["rises"]) == 12_000 for p in drawn["packed"])
    assert drawn["whole"] == [0.0, pytest.approx(59.995)]


def test_the_waterfall_starts_and_ends_at_the_errors_and_its_steps_join() -> None:
    steps = [
        {"added": a, "rmse_held_out": e}
        for a, e in ((None, 0.9), ("coulomb_friction", 0.5), ("end_stop", 0.2))
    ]
    (figure,) = falling_error.section(view(steps=steps)).figures  # type: ignore[union-attr]
    start, falls, end = (m for m in figure.panels[0].marks if isinstance(m, Bars))
    assert (start.size[0], end.size[0]) == (0.9, 0.2)
    assert falls.base is not None
    np.testing.assert_allclose(falls.base + falls.size, [0.9, 0.5])
    np.testing.assert_allclose(falls.base, [0.5, 0.2])
    assert [t.split("\n")[0] for _, t in figure.panels[0].x.ticks] == [
        "model, refitted", "+ Coulomb friction", "+ End stop", "remains",
    ]  # fmt: skip


def test_bars_of_candidates_are_not_negative_and_name_their_effects() -> None:
    (figure,) = candidates.section(view()).figures  # type: ignore[union-attr]
    bars = [m for m in figure.panels[0].marks if isinstance(m, Bars)]
    assert {b.name for b in bars} == {
        "present",
        "explained better by another",
        "not excited",
        "not needed",
    }
    shown = {float(a): (s, t) for b in bars for a, s, t in zip(b.at, b.size, b.text, strict=True)}
    named = {name: shown[at] for at, name in figure.panels[0].y.ticks}
    assert named["Coulomb friction"] == (0.51, "0.510 N")
    assert named["Force lag"] == (0.0, "no gain")
    (level,) = [m for m in figure.panels[0].marks if isinstance(m, Level)]
    assert level.value == 0.022


def test_the_spectrum_keeps_the_power_and_finds_a_hum() -> None:
    r = record("a", 40.0, 3)
    hum = replace(r, before=r.measured - 0.5 * np.sin(2 * np.pi * 25.0 * r.t))
    f, amplitude = spectrum.density([hum.measured - hum.before], [hum])
    assert f[np.argmax(amplitude)] == pytest.approx(25.0, abs=0.2)
    power = np.sum(amplitude**2) * (f[1] - f[0])
    assert np.sqrt(power) == pytest.approx(0.5 / np.sqrt(2), rel=0.02)


def test_maps_hold_the_rms_of_their_tiles_and_leave_empty_ones_empty() -> None:
    rng = np.random.default_rng(0)
    x, y = rng.uniform(0, 1, 20_000), rng.uniform(0, 1, 20_000)
    value = np.where(x > 0.5, 3.0, 1.0)
    _, _, z = rms_map(x, y, value, (4, 2))
    np.testing.assert_allclose(z, [[1, 1, 3, 3]] * 2, rtol=0.05)
    _, _, holes = rms_map(np.r_[x * 0.4, 0.6 + x * 0.4], np.r_[y, y], np.r_[value, value], (10, 2))
    assert np.isnan(holes[:, 4]).all()


def test_the_mean_residual_shows_a_step_at_zero_velocity() -> None:
    v = np.random.default_rng(0).uniform(-1, 1, 5000)
    x, mean = binned_mean(v, np.sign(v))
    np.testing.assert_allclose(mean[np.abs(x) > 0.2], np.sign(x[np.abs(x) > 0.2]))
    assert x.min() < -0.98, "the ends of the range are seen too"


def test_the_maps_share_one_scale_before_and_after() -> None:
    _, maps = residual_maps.section(view()).figures  # type: ignore[union-attr]
    assert [p.title for p in maps.panels] == ["model before"] * 2 + ["model after"] * 2
    peaks = [float(np.nanmax(p.marks[0].z)) for p in maps.panels]  # type: ignore[union-attr]
    assert max(peaks[:2]) > 2 * max(peaks[2:])
    assert maps.scale is not None
    constant = compared()
    constant = replace(
        constant, records=tuple(replace(r, duty=0 * r.duty) for r in constant.records)
    )
    _, maps = residual_maps.section(constant).figures  # type: ignore[union-attr]
    assert len(maps.panels) == 1, "no map over a duty that never changes"


def test_a_card_draws_the_signature_over_the_residual_in_its_plane() -> None:
    r = record("a", 10.0, 1)
    c = replace(
        card("end_stop", 0.2, r), plane="force-deflection", signature_x=r.deflection[100::17]
    )
    section = cards.section(replace(view(), candidates=(c,)))
    assert section is not None
    (figure,) = section.figures
    left, explained, *means = figure.panels[0].marks
    for mean, dots in zip(means, (left, explained), strict=True):
        assert rms(mean.y) < rms(dots.y)
        assert mean.x.min() >= dots.x.min()
    assert isinstance(left, Points)
    assert isinstance(explained, Points)
    assert figure.panels[0].x.label == "deflection [mm]"
    assert rms(left.y) > rms(explained.y)
    np.testing.assert_allclose(left.x, 1e3 * r.deflection[100::17])

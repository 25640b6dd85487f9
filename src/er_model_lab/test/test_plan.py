"""Planning an experiment: limits, strengths, what imitates what, and the program that is proposed."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from er_model_lab.cli.running import _with_next
from er_model_lab.level.investigate import investigate
from er_model_lab.planning import motions_and_duties, piece, planner, search
from er_model_lab.planning.explanation import sentences
from er_model_lab.planning.finalist import finalist
from er_model_lab.planning.limits import Asked, Limits, Sensors, limits_of, sensors_of
from er_model_lab.planning.linear import Triangle
from er_model_lab.planning.planner import Plan
from er_model_lab.planning.present import plan_json
from er_model_lab.planning.question import Question, ask
from er_model_lab.planning.segment import Segment, in_words, program_of
from er_model_lab.planning.setup import bench_for
from er_model_lab.planning.simulated_decision import NOTHING, TIED, decision, measured
from er_model_lab.planning.suggest import suggestions
from er_model_lab.planning.virtual_rig import run_all
from er_model_lab.problem.prepare import prepare
from er_model_lab.results.result import DiagnosisResult
from er_model_lab.verbs import asking
from er_model_lab.view import View
from er_models.errors import ErError, InputError
from er_models.files import load_model
from er_models.model import Model
from er_models.program import load_program, save_program, times
from er_models.simulation import simulate
from er_records.dataset import Dataset

CONFIG = Path(__file__).resolve().parents[3] / "config"
DT = 0.005


def car() -> Model:
    return load_model(CONFIG / "vehicles/inove_quarter_car.yaml")


def damper() -> Model:
    return load_model(CONFIG / "dampers/inove_guo.yaml")


def question(model: Model, *names: str) -> Question:
    return ask(model, names, None) if len(names) == 2 else ask(model, (), names[0])


def bench(model: Model, *names: str, **limits: float) -> piece.Bench:
    asked = question(model, *names)
    sensors, _ = sensors_of(model, None)
    return bench_for(asked, limits_of(model, Asked(**limits), DT), sensors, None, 0)


def planned(model: Model, *names: str, **limits: float) -> Plan:
    sensors, _ = sensors_of(model, None)
    within = limits_of(model, Asked(**limits), DT)
    return planner.planned(question(model, *names), within, sensors)


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search of a few pieces and few simulated measurements."""
    monkeypatch.setattr(motions_and_duties, "SPEEDS", (1.0, 4.0))
    monkeypatch.setattr(search, "MOTIONS_KEPT", 1)
    monkeypatch.setattr(search, "SWEEPS", 0)
    monkeypatch.setattr(planner, "SETS", 1)
    monkeypatch.setattr(planner, "MEASUREMENTS", 2)


@pytest.fixture(scope="module")
def stops() -> Plan:
    """Gas spring or end stop, on the car of the testbench."""
    return planned(car(), "gas_spring", "end_stop")


@pytest.mark.slow
def test_the_limits_hold_whichever_is_true(stops: Plan) -> None:
    """In the plant's own simulation of every program that is proposed."""
    limits = stops.bench.limits
    assert (limits.stroke, limits.velocity, limits.duty) == (0.012, 0.15, 0.3)
    for found in stops.finalists:
        t = times(found.program.duration, DT)
        road, duty = found.program.signals(t)
        assert duty.max() <= limits.duty
        assert np.abs(road).max() <= limits.road
        for model in stops.bench.models.values():
            out = simulate(model, DT, road, duty)
            assert np.abs(out["deflection"]).max() <= limits.stroke
            assert np.abs(out["deflection_velocity"]).max() <= limits.velocity
    assert stops.best.used["velocity"] > 0.9 * limits.velocity


@pytest.mark.slow
def test_a_program_that_asks_for_too_much_is_made_smaller(stops: Plan) -> None:
    limits = stops.bench.limits
    found = finalist("large", [s.scaled(3.0) for s in stops.best.segments], stops.bench)
    assert found is not None
    assert found.used["velocity"] <= limits.velocity
    assert found.used["stroke"] <= limits.stroke
    assert found.used["road"] <= limits.road
    assert max(found.used[k] / getattr(limits, k) for k in ("velocity", "stroke", "road")) > 0.9


def test_the_program_separates_where_others_do_not(stops: Plan) -> None:
    best, gentle = stops.best, poor(stops.bench)
    assert stops.everyday is not None
    for truth in ("gas_spring", "end_stop"):
        far = best.directions[truth].separation
        assert far > 0.5
        assert far > 10.0 * gentle.directions[truth].separation
        assert far > 5.0 * stops.everyday.directions[truth].separation
    assert stops.verdict == "told_apart"
    assert all(o.right >= 4 for o in stops.outcomes.values())
    assert sum(o.right for o in stops.everyday_outcomes.values()) < 5


def poor(found: piece.Bench) -> planner.Finalist:
    """A gentle motion at one duty."""
    several = next(
        m for m in motions_and_duties.motions(found.limits) if m.road["kind"] == "multisine"
    )
    segment = replace(several, duty={"kind": "constant", "level": 0.15}, level=0.2)
    ready = piece.scaled(segment, found)
    assert ready is not None
    program = finalist("poor", [ready[0]], found)
    assert program is not None
    return program


def test_the_reasons_name_place_and_numbers(stops: Plan) -> None:
    text = " ".join(sentences(stops))
    assert "at deflection" in text
    assert f"{stops.best.directions['end_stop'].gap:.3g} N" in text
    assert "random road with random steps" in text
    assert "Raising" not in text


def test_the_result_holds_what_is_needed_to_run_and_to_judge(stops: Plan, tmp_path: Path) -> None:
    result = plan_json(stops, "the model's rig")
    assert result["between"] == ["gas_spring", "end_stop"]
    assert result["moves"] == "wheel"
    first = result["programs"][0]
    assert set(first["separation"]) == {"gas_spring", "end_stop"}
    ranks = [round(min(p["separation"].values()), 2) for p in result["programs"]]
    assert ranks == sorted(ranks, reverse=True)
    share = result["measurements"]["end_stop"]
    assert share["interval"][0] < share["probability"] <= 1.0
    assert result["strengths"]["end_stop"]["parameters"]["x_b"][2] == "m"
    save_program(stops.best.program, tmp_path / "p.yaml")
    again = load_program(tmp_path / "p.yaml")
    t = times(again.duration, DT)
    for a, b in zip(again.signals(t), stops.best.program.signals(t), strict=True):
        assert np.array_equal(a, b)


def test_the_linear_estimate_agrees_with_the_labs_own_refits(stops: Plan) -> None:
    """Within a factor of two: it only has to order hundreds of programs."""
    pieces = [p for s in stops.best.segments if (p := piece.judged(s, stops.bench)) is not None]
    estimate = piece.separations(pieces)
    for truth, direction in stops.best.directions.items():
        assert 0.5 < direction.separation / estimate[truth] < 2.0


def test_an_effect_stands_out_as_much_as_the_noise(stops: Plan) -> None:
    for name in ("gas_spring", "end_stop"):
        assert stops.bench.rivals.shown[name] == pytest.approx(1.0, rel=0.1)


@pytest.mark.slow
@pytest.mark.usefixtures("quick")
def test_what_fades_with_the_time_is_told_from_what_fades_with_the_heat() -> None:
    """Within the limits, by a program in which power and springs change."""
    found = planned(car(), "self_heating", "force_fade")
    limits = found.bench.limits
    assert found.verdict == "told_apart"
    assert found.best.used["stroke"] <= limits.stroke
    assert found.best.used["velocity"] <= limits.velocity
    assert found.everyday is not None
    for truth in ("self_heating", "force_fade"):
        apart = found.best.directions[truth].separation
        assert apart > 3.0 * found.everyday.directions[truth].separation


@pytest.mark.slow
@pytest.mark.usefixtures("quick")
def test_without_stroke_the_end_stop_stays_hidden_and_the_plan_says_so() -> None:
    """A stroke of 4 mm never reaches a stop that begins at 6 mm; twice the stroke would."""
    found = planned(car(), "end_stop", stroke=0.004)
    assert found.verdict == "not_told_apart"
    assert found.best.directions["end_stop"].separation < 0.05
    assert found.outcomes["end_stop"].named == {NOTHING: 2}
    text = " ".join(sentences(found))
    assert "Raising the stroke to 0.008 m would" in text
    assert plan_json(found, "")["verdict"] == "not_revealed"


def test_what_contains_another_imitates_it_and_that_does_not_count() -> None:
    """Stribeck friction without its peak is Coulomb friction."""
    found = bench(damper(), "coulomb_friction", "stribeck_friction")
    several = [
        m for m in motions_and_duties.motions(found.limits) if m.road["kind"] == "multisine"
    ][:1]
    pieces = [p for m in several if (p := piece.judged(m, found)) is not None]
    apart = piece.separations(pieces)
    assert apart["coulomb_friction"] < 0.02
    assert apart["stribeck_friction"] > 0.1
    assert search.directions(pieces) == ("stribeck_friction",)


def test_the_lab_names_ties_and_nothing_as_it_does_elsewhere() -> None:
    """On a fast square wave of the duty a dead time is named; on a held duty nothing is."""
    found = bench(car(), "dead_time", "amplifier_lag")
    road = {
        "kind": "multisine",
        "amplitudes": [0.01, 0.004, 0.002],
        "frequencies": [1.3, 3.1, 7.7],
    }
    named = {}
    for level in (0.0, 0.3):
        duty = motions_and_duties.square(level, 0.3, 11.0)
        ready = piece.scaled(Segment(road, duty, 15.0, tones=(1.3, 3.1, 7.7)), found)
        assert ready is not None
        record = measured(ready[1]["dead_time"], found.sensors, np.random.default_rng(1), "r")
        named[level] = decision(found.rivals.question, prepare(Dataset.of([record])), 0)
    assert named[0.0] == "dead_time"
    assert named[0.3] in (TIED, NOTHING)


def test_in_a_machine_the_deflection_is_minus_the_road() -> None:
    model = damper().with_effect("coulomb_friction")
    road = {"kind": "sine", "amplitude": 0.01, "frequency": 2.0}
    segment = Segment(road, {"kind": "constant", "level": 0.2}, 5.0)
    limits = limits_of(model, Asked(), DT)
    program = program_of([segment], limits, seed=0, car=False, once=True)
    assert program.moves == "damper"
    made = run_all({"": model}, program, DT)[""]
    t, x = made.channels["t"], made.channels["deflection"]
    inside = (t > 1.0) & (t < 4.0)
    w = 4.0 * np.pi
    assert x[inside] == pytest.approx(-0.01 * np.sin(w * t[inside]), abs=1e-9)
    v = made.channels["deflection_velocity"][inside]
    assert v == pytest.approx(-0.01 * w * np.cos(w * t[inside]), abs=1e-5)
    a = made.motion.a[inside]
    assert a == pytest.approx(0.01 * w**2 * np.sin(w * t[inside]), abs=1e-3)
    force = 1.05 * np.tanh(v / 0.003)
    bare = run_all({"": damper()}, program, DT)[""].channels["damper_force"][inside]
    assert made.channels["damper_force"][inside] - bare == pytest.approx(force, abs=1e-2)


def test_an_effect_that_the_model_holds_is_taken_out_and_keeps_its_strength() -> None:
    model = damper().with_effect("coulomb_friction", {"F_c": 0.7, "v_0": 0.004})
    asked = question(model, "coulomb_friction", "bouc_wen_hysteresis")
    assert "coulomb_friction" not in asked.base.effects
    found = bench(model, "coulomb_friction", "bouc_wen_hysteresis")
    assert found.rivals.truths["coulomb_friction"].value("coulomb_friction", "F_c") == 0.7
    assert found.rivals.sources["coulomb_friction"] == "the model's own"
    assert found.rivals.sources["bouc_wen_hysteresis"] != "the model's own"


def test_with_data_the_effects_are_as_they_are_fitted_to_them() -> None:
    """What the data hardly show stands out instead, and the result says so."""
    base, limits = damper(), limits_of(damper(), Asked(duration=15.0), DT)
    truth = base.with_effect("coulomb_friction", {"F_c": 0.8, "v_0": 0.003})
    road = {
        "kind": "multisine",
        "amplitudes": [0.004, 0.002, 0.001],
        "frequencies": [1.3, 3.1, 6.7],
    }
    program = program_of([Segment(road, {"kind": "steps"}, 15.0)], limits, seed=0, car=False)
    sensors, _ = sensors_of(base, None)
    made = run_all({"": truth}, program, DT)[""]
    problem = prepare(Dataset.of([measured(made, sensors, np.random.default_rng(0), "r")]))
    known, source = sensors_of(base, problem)
    assert source == "the data"
    assert known.force == pytest.approx(0.15, rel=0.3)
    found = bench_for(question(base, "coulomb_friction", "end_stop"), limits, known, problem, 0)
    fitted = found.rivals.truths["coulomb_friction"]
    sd = fitted.deviations["coulomb_friction"]["F_c"]
    assert abs(fitted.value("coulomb_friction", "F_c") - 0.8) < 4.0 * sd
    assert found.rivals.sources["coulomb_friction"] == "fitted to the data"
    assert found.rivals.sources["end_stop"] != "fitted to the data"


WRONG = {
    "unknown": (("coulomb_fricton", "end_stop"), None, "'coulomb_fricton'; did you mean coulomb_friction"),
    "twice": (("end_stop", "end_stop"), None, "expected two different effects, found 'end_stop' twice"),
    "unknowable": (("force_gain", "end_stop"), None, "force_gain cannot be known from these channels"),
    "of the vehicle": (("tyre_damping", "end_stop"), None, "tyre_damping acts in the vehicle"),
    "of the model itself": (("passive", "end_stop"), None, "passive is a term of the damper model"),
    "kinematic": ((), "velocity_lag", "velocity_lag needs no plan"),
    "nothing": ((), None, "either between, two effects, or reveal, one, found neither"),
    "both": (("gas_spring", "end_stop"), "end_stop", "found both"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", WRONG)
def test_a_question_that_cannot_be_asked_is_one_line(mistake: str) -> None:
    between, reveal, words = WRONG[mistake]
    with pytest.raises(ErError) as caught:
        ask(damper(), between, reveal)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
    assert caught.value.exit_status == 2


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        (Asked(stroke=0.0), "stroke: expected a number above 0 in m, found 0"),
        (Asked(velocity=-1.0), "velocity: expected a number above 0 in m/s, found -1"),
        (Asked(duty=1.5), "duty_max: expected a duty of at most 1, found 1.5"),
        (Asked(duration=1.0), "duration: expected 10 to 600 s, found 1"),
        (Asked(stroke=float("nan")), "stroke: expected a number above 0 in m, found nan"),
    ],
)
def test_limits_that_make_no_sense_are_named(asked: Asked, words: str) -> None:
    with pytest.raises(InputError) as caught:
        limits_of(damper(), asked, DT)
    assert str(caught.value) == words


def test_limits_and_noise_come_from_the_rig_else_from_the_envelope() -> None:
    assert sensors_of(damper(), None) == (Sensors(2e-5, 1e-3, 0.025, 0.15), "the model's rig")
    strange = replace(damper(), rig={})
    limits, (sensors, source) = limits_of(strange, Asked(), DT), sensors_of(strange, None)
    assert (limits.stroke, limits.velocity, limits.duty) == (0.01, 0.15, 0.3)
    assert source.startswith("assumed")
    larger = replace(strange, scales=replace(strange.scales, force=2100.0))
    assert sensors_of(larger, None)[0].force == pytest.approx(100.0 * sensors.force)


def test_every_piece_of_the_menu_is_sized_by_the_limits_alone() -> None:
    """A rig of ten times the stroke and velocity gets the same frequencies and ten times the size."""
    small = Limits(0.012, 0.15, 0.3, 0.036)
    large = Limits(0.12, 1.5, 0.3, 0.36)
    pairs = list(
        zip(motions_and_duties.motions(small), motions_and_duties.motions(large), strict=True)
    )
    assert len(pairs) > 15
    for one, other in pairs:
        assert one.road.get("frequency") == other.road.get("frequency")
        if "amplitude" in one.road:
            assert other.road["amplitude"] == pytest.approx(10.0 * one.road["amplitude"])
        assert one.seconds == other.seconds
        kinds = zip(
            motions_and_duties.duties(small, one),
            motions_and_duties.duties(large, other),
            strict=True,
        )
        assert all(a == b for a, b in kinds)
        assert in_words(one)


def test_a_diagnosis_suggests_the_plan_for_what_it_could_not_decide() -> None:
    tied = {"alternatives": [["dead_time", "amplifier_lag", "rise_fall_asymmetry"]]}
    assert suggestions(tied) == [{"between": ["dead_time", "amplifier_lag"]}]
    states = [("velocity_lag", "not_excited"), ("preload", "absent"), ("end_stop", "not_excited")]
    hidden = {"candidates": [{"effect": e, "status": s} for e, s in states]}
    assert suggestions(hidden) == [{"reveal": "end_stop"}]
    assert suggestions({"candidates": []}) == []


def commands(read: dict[str, list[Path]], *plans: dict[str, Any]) -> list[str]:
    """What the command line makes of suggested plans."""
    content = {"next_plans": list(plans)}
    view = View("diagnose", "m", "", content, ())
    told: list[str] = _with_next(DiagnosisResult(view), read).view.result["next"]
    return told


def test_a_suggested_plan_is_a_command_that_is_ready_to_be_pasted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    read = {"--model": [Path("m.yaml")], "DATA": [Path("a b.csv")], "--effects-from": []}
    tied, hidden = {"between": ["dead_time", "amplifier_lag"]}, {"reveal": "end_stop"}
    monkeypatch.setattr(sys, "argv", ["lab"])
    assert commands(read, tied) == [
        "./er lab plan --model m.yaml --data 'a b.csv' --between dead_time amplifier_lag --out next.yaml"
    ]
    assert commands(read | {"DATA": []}, hidden) == [
        "./er lab plan --model m.yaml --reveal end_stop --out next.yaml"
    ]
    assert commands(read) == []
    own = read | {"DATA": [Path("d.csv")], "--effects-from": [Path("own.py")]}
    monkeypatch.setattr(sys, "argv", ["lab", "--anyway"])
    (anyway,) = commands(own, hidden)
    assert "--data d.csv --effects-from own.py --anyway --reveal" in anyway


@pytest.mark.parametrize("model", [damper(), car()], ids=["machine", "car"])
def test_limits_are_those_of_the_damper_whatever_its_sensors_read(model: Model) -> None:
    """A deflection sensor that is zeroed at one end of the stroke, and a velocity sensor that is out of scale."""
    odd = model.with_effect("deflection_zero", {"x_0": -0.0125})
    odd = odd.with_effect("velocity_gain", {"g_v": 1.3})
    limits = limits_of(model, Asked(), DT)
    program = program_of(
        motions_and_duties.rich(limits)[:1], limits, seed=0, car=model.is_vehicle, once=True
    )
    plain, read = (run_all({"": m}, program, DT)[""] for m in (model, odd))
    for name, peak in plain.used().items():
        assert read.used()[name] == pytest.approx(peak, rel=1e-6)
    moved = read.channels["deflection"] - plain.channels["deflection"]
    assert moved == pytest.approx(np.full_like(moved, 0.0125), abs=1e-9)


def test_a_set_of_pieces_is_no_longer_than_the_program() -> None:
    """What does not run tells nothing, and is not counted as motion of several frequencies."""
    motions = [
        m for m in motions_and_duties.motions(Limits(0.012, 0.15, 0.3, 0.036)) if len(m.tones) == 1
    ][:6]

    def tried(motion: Segment, worth: float, *tones: float) -> piece.Tried:
        told, none = (Triangle(np.array([[w]]), 1) for w in (worth, 0.0))
        return piece.Tried(replace(motion, seconds=9.0, tones=tones), {"": (told,)}, {"": none})

    two = [tried(m, 1.0 + 0.001 * k, 1.0 + k, 1.5 + k) for k, m in enumerate(motions)]
    assert search.best_sets(two, ("",), 3, 17.0) == []  # two sines are a single tone for the lab
    for longest in (18.0, 30.0):
        found = search.best_sets(two, ("",), 3, longest)
        assert found
        assert all(9.0 * len(c) <= longest and piece.broad(c) for c in found)
    three = [tried(m, 1.0 + 0.001 * k, 1.0, 2.0, 3.0 + k) for k, m in enumerate(motions)]
    assert {len(chosen) for chosen in search.best_sets(three, ("",), 3, 10.0)} == {1}
    assert search.best_sets(three, ("",), 3, 8.0) == []
    told, none = (Triangle(np.array([[w]]), 1) for w in (1.0, 0.0))
    halves = [  # each tells one of two truths, so that two tell more
        replace(
            p,
            parts={n: (told if n == "ab"[k % 2] else none,) for n in "ab"},
            own={n: none for n in "ab"},
        )
        for k, p in enumerate(three)
    ]
    for longest, most in ((10.0, 1), (20.0, 2)):
        found = search.best_sets(halves, ("a", "b"), 3, longest)
        assert max(len(chosen) for chosen in found) == most


def test_where_nothing_fits_the_limits_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(motions_and_duties, "rich", lambda limits: [])
    with pytest.raises(
        InputError, match=r"limits \(stroke, velocity, duration\).*found 12 mm, 0.15 m/s, 30 s"
    ):
        bench(damper(), "coulomb_friction", "gas_spring")


@pytest.fixture(scope="module")
def late() -> tuple[piece.Bench, planner.Finalist]:
    """Dead time or a lag of the amplifier, and the program that tells them apart."""
    found = bench(car(), "dead_time", "amplifier_lag")
    pieces = search.tried_menu(found)
    chosen = search.best_sets(pieces, ("dead_time", "amplifier_lag"), 1, 30.0)[0]
    program = finalist("program", [p.segment for p in chosen], found)
    assert program is not None
    return found, program


@pytest.mark.slow
@pytest.mark.parametrize("truth", ["dead_time", "amplifier_lag"])
def test_the_whole_lab_names_the_truth_from_the_planned_program_only(
    truth: str, late: tuple[piece.Bench, planner.Finalist]
) -> None:
    """All effects compete; a gentle drive at one duty, whose noise is the same, leaves the two tied."""
    found, program = late
    for made, right in ((program.runs, True), (poor(found).runs, False)):
        record = measured(made[truth], found.sensors, np.random.default_rng(42), "r")
        if right:
            asked = asking.question(Dataset.of([record]), found.rivals.question.base)
            diagnosis = investigate(asked).diagnosis
            assert diagnosis.verdict == "missing_effect"
            assert diagnosis.effects == (truth,)
        else:
            assert decision(found.rivals.question, prepare(Dataset.of([record])), 0) in (
                TIED,
                NOTHING,
            )

"""Passes of `improve` are told as one, each effect as the pass saw it that took it."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from er_model_lab.diagnosis.candidates import baseline, refit
from er_model_lab.diagnosis.investigation import judge, search_effects
from er_model_lab.diagnosis.noise_floor import Floor
from er_model_lab.diagnosis.null import Null
from er_model_lab.diagnosis.rule import RULE
from er_model_lab.diagnosis.search import Round
from er_model_lab.diagnosis.verdict import NOTHING_NAMED
from er_model_lab.level.level import Question
from er_model_lab.level.study import Study, summary
from er_model_lab.results.candidate import candidates as entries
from er_model_lab.results.passes import explained_by, of_the_last, taken_last, told_together
from er_model_lab.verbs import improve, veto
from er_model_lab.work import Cancelled
from er_models.files import load_model
from lab_help import EVIDENCE, GUO, asked, problem_of
from report_views import card, record


def found(effects, verdict="partial", candidates=(), rmse=1.0, alternatives=()):
    """The result of one pass; candidates: {effect: (status, value)}."""
    return {
        "verdict": verdict,
        "effects": list(effects),
        "alternatives": [list(g) for g in alternatives],
        "candidates": [
            {"effect": name, "status": status, "parameters": {"p": [value, 0.1, "N"]}}
            for name, (status, value) in dict(candidates).items()
        ],
        "steps": [{"added": None, "rmse_held_out": 9.0}, *({"added": e} for e in effects)],
        "reasons": [f"reason of {verdict}"],
        "rmse_after": {"held_out": rmse},
        "noise_floor": rmse / 2.0,
        "floors": {},
        "unexplained": {},
    }


def told(results, dropped=None):
    """Passes as one, the last of which had the evidence for its verdict."""
    return told_together(results, EVIDENCE[results[-1]["verdict"]], dropped=dropped)


FIRST = found(
    ["preload"], candidates={"preload": ("present", 5.0), "cavitation": ("absent", 0.0), "freeplay": ("absent", 1.0)}
)  # fmt: skip


def test_what_a_later_pass_took_is_told_as_that_pass_saw_it():
    later = found(
        ["cavitation"], "missing_effect", {"cavitation": ("present", 8.8), "freeplay": ("absent", 3.0)}, rmse=0.5
    )  # fmt: skip
    whole = told([FIRST, later])
    assert whole["effects"] == ["preload", "cavitation"]
    assert [c["effect"] for c in whole["candidates"]] == ["preload", "cavitation", "freeplay"]
    assert [c["status"] for c in whole["candidates"]] == ["present", "present", "absent"]
    assert [c["parameters"]["p"][0] for c in whole["candidates"]] == [5.0, 8.8, 1.0]
    assert [s["added"] for s in whole["steps"]] == [None, "preload", "cavitation"]
    assert (whole["rmse_after"], whole["noise_floor"]) == ({"held_out": 0.5}, 0.25)
    assert (whole["verdict"], whole["final_verdict"]) == ("missing_effect", "adequate")
    assert whole["reasons"] == ["reason of partial", "reason of missing_effect"]
    assert FIRST["effects"] == ["preload"]


@pytest.mark.parametrize(
    ("come", "better"), [(["cavitation"], ["cavitation"]), ([], ["freeplay"])]
)
def test_what_was_taken_and_went_again_is_told_as_absent(come, better):
    later = found(["freeplay"], candidates={"freeplay": ("present", 3.0)})
    whole = told([FIRST, later], dropped={"preload": come})
    assert whole["effects"] == ["freeplay"]
    (gone,) = (c for c in whole["candidates"] if c["effect"] == "preload")
    assert (gone["status"], gone["explained_by"]) == ("absent", better)
    assert FIRST["candidates"][0]["status"] == "present"


def test_one_pass_is_told_as_it_is():
    whole = told([FIRST])
    assert whole == FIRST | {"final_verdict": "partial"}


def test_what_is_left_after_all_passes_is_told_of_each_record_and_output_too():
    def with_more(result, left):
        sides = {"rmse_after": left, "noise_floor": left / 2.0}
        by_record = {"record": "a", "rmse_before": 9.0, "rmse_after": left, "rmse_left_out": left}
        return result | {
            "by_record": [by_record], "channels": {"deflection": {"rmse": 9.0, **sides}},
            "confounded": [[f"{left}"]], "noise_floor_train": left,
        }  # fmt: skip

    first, later = with_more(FIRST, 1.0), with_more(found(["cavitation"], rmse=0.5), 0.5)
    later["by_record"][0]["rmse_before"] = later["channels"]["deflection"]["rmse"] = 1.0
    whole = told([first, later])
    (record,) = whole["by_record"]
    assert record == {"record": "a", "rmse_before": 9.0, "rmse_after": 0.5, "rmse_left_out": 0.5}
    assert whole["channels"] == {
        "deflection": {"rmse": 9.0, "rmse_after": 0.5, "noise_floor": 0.25}
    }
    assert (whole["confounded"], whole["noise_floor_train"]) == ([["0.5"]], 0.5)


def test_passes_over_other_stretches_of_long_data_are_told_by_record():
    def long(before, after):
        return {
            "rmse": {"before": {"all": before}, "after": {"all": after}},
            "searched_again": after < 1,
        }

    def records(names, left):
        return [
            {"record": n, "rmse_before": 9.0, "rmse_after": left, "rmse_left_out": left}
            for n in names
        ]

    first = FIRST | {"by_record": records("abc", 1.0), "long": long(9.0, 1.0)}
    later = found(["cavitation"], rmse=0.5) | {
        "by_record": records("bcde", 0.5),
        "long": long(1.0, 0.5),
    }
    whole = told([first, later])
    assert [(r["record"], r["rmse_after"]) for r in whole["by_record"]] == [
        ("a", 1.0),
        ("b", 0.5),
        ("c", 0.5),
    ]
    assert whole["long"] == {
        "rmse": {"before": {"all": 9.0}, "after": {"all": 0.5}},
        "searched_again": True,
    }


def test_what_all_passes_explain_is_counted_from_the_first_model_to_the_last():
    def pass_(before, after, floor):
        made = SimpleNamespace
        return made(base=made(mse=before), best=made(mse=after), floor=made(floor=floor))

    both = explained_by(pass_(10.0, 4.0, 1.5), pass_(4.0, 1.1, 1.0))
    assert both["explainable"] == pytest.approx(0.9)
    assert both["explained"] == pytest.approx(8.9 / 9.0)


def test_a_tie_of_a_later_pass_stays():
    seen = {"cavitation": ("confounded", 8.8), "freeplay": ("confounded", 3.0)}
    later = found(["cavitation"], "ambiguous", seen, alternatives=[("cavitation", "freeplay")])
    whole = told([FIRST, later])
    assert whole["alternatives"] == [["cavitation", "freeplay"]]
    assert whole["verdict"] == "ambiguous"
    said = [(c["effect"], c["status"]) for c in whole["candidates"]]
    assert said == [
        ("preload", "present"), ("cavitation", "confounded"), ("freeplay", "confounded")
    ]  # fmt: skip


def test_as_many_effects_as_a_search_names_are_no_cause_where_more_than_noise_is_left():
    later = found(["cavitation", "freeplay"], "missing_effect", rmse=1.0)
    assert told([FIRST, later])["verdict"] == "partial"
    assert told([FIRST, later | {"noise_floor": 0.99}])["verdict"] == "missing_effect"
    assert told([FIRST, found(["cavitation"], "missing_effect")])["verdict"] == ("missing_effect")


def test_no_noise_is_louder_than_what_a_model_of_an_earlier_pass_left():
    first, *others = FIRST["candidates"]
    seen = FIRST | {"candidates": [first | {"rmse_held_out": 0.4}, *others]}
    later = found(["freeplay"], "missing_effect", rmse=1.0)
    assert told([seen, later])["noise_floor"] == 0.4
    assert told([seen | {"noise_floor": 0.1}, later])["noise_floor"] == 0.4, (
        "the floor is that of the last model"
    )
    assert told([seen, later | {"long": {"rmse": {}}}])["noise_floor"] == 0.5, "of other samples"


def test_cards_of_what_a_later_pass_took_come_after_those_of_the_first():
    r = record("run", 4.0, 0)
    first = tuple(
        card(name, size, r)
        for name, size in (("preload", 2.0), ("freeplay", 1.0), ("cavitation", 0.1))
    )
    later = (card("cavitation", 0.7, r), card("freeplay", 0.2, r))
    kept = taken_last([first, later], [FIRST, found(["cavitation"])])
    assert [c.effect for c in kept] == ["preload", "cavitation", "freeplay"]
    assert kept[1] is later[0]
    assert kept[2] is first[1]
    tied = found(["cavitation"], alternatives=[("cavitation", "freeplay")])
    assert taken_last([first, later], [FIRST, tied]) == (first[0], *later)


def passes_of(monkeypatch):
    """The passes of `improve` over stand-ins: a model is the effects that were found, and has no history."""
    monkeypatch.setattr(improve, "with_history", lambda best, *_: best)
    monkeypatch.setattr(improve, "marked", lambda model, _: model)
    monkeypatch.setattr(improve, "begun", lambda model, *_: model)
    level = SimpleNamespace(finished=lambda study, _: study.diagnosis.effects)
    asked = Question(data=None, model=(), level=level, preflight=None)
    return improve._passes(asked, SimpleNamespace(noted={}, digest=""), "m", None)


@pytest.mark.parametrize(("later", "taken"), [(0.9, True), (1.04, True), (1.2, False)])
def test_a_later_pass_that_makes_held_out_data_worse_is_not_taken(monkeypatch, later, taken):
    """What the data that are learnt from ask for may be wrong elsewhere: the better model is kept, and it is told.

    It is looked for once more without what was refused, which may hide another effect.
    """

    def study(before, after, effects):
        left = [
            SimpleNamespace(
                fit=SimpleNamespace(residual=np.full(8, e)), mse=e * e, seen=e * e, effects=()
            )
            for e in (before, after)
        ]
        found = Search(effects, left[1], (), base=left[0])
        return Part(diagnosis=found, problem=problem)

    problem = SimpleNamespace(
        train=np.arange(8) < 4, held_out=np.arange(8) >= 4, force=np.arange(8.0),
        forward=SimpleNamespace(outputs=1),
    )  # fmt: skip
    studies = iter(
        [study(2.0, 1.0, ("preload",)), study(1.0, later, ("end_stop",)), study(1, 1, ())]
    )
    barred = []

    def investigate(now, *_):
        barred.append({*now.rule.barred})
        return next(studies)

    monkeypatch.setattr(improve, "investigate", investigate)
    monkeypatch.setattr(improve, "MOST_PASSES", 2)
    made = passes_of(monkeypatch)
    second = ("end_stop",) if taken else ()
    assert [s.diagnosis.effects for s in made.studies] == [("preload",), second]
    assert made.model == (second or ("preload",))
    assert ("end_stop not added" in " ".join(made.notes)) != taken
    assert barred == [set(), set()] + ([] if taken else [{"end_stop"}])


def test_a_pass_does_not_begin_with_what_held_out_data_refused_of_the_one_before(monkeypatch):
    one, rules = SimpleNamespace(residual=np.ones(8)), []
    studies = {
        names: Part(diagnosis=Search(names, Part(fit=one), (), base=Part(fit=one)))
        for names in (("preload", "remanence"), ("preload",))
    }

    def investigate(now, *_):
        rules.append(now.rule)
        if len(rules) > 1:
            raise Cancelled
        return studies["preload", "remanence"]

    monkeypatch.setattr(improve, "investigate", investigate)
    monkeypatch.setattr(improve, "weighed", lambda *_, later: (studies["preload",], ()))
    monkeypatch.setattr(improve, "refused", lambda study, rule, given: (rule, ()))
    passes_of(monkeypatch)
    assert [{*r.barred} for r in rules] == [set(), {"remanence"}]
    assert rules[1].small_steps


def test_ctrl_c_while_held_out_data_are_asked_keeps_what_was_found(monkeypatch):
    def asked_of(study, *_, later):
        if later:
            raise Cancelled
        return study, ()

    fit = SimpleNamespace(fit=SimpleNamespace(residual=np.ones(8)))
    study = Part(diagnosis=Search(("preload",), fit, (), base=fit))
    monkeypatch.setattr(improve, "investigate", lambda *_: study)
    monkeypatch.setattr(improve, "weighed", asked_of)
    made = passes_of(monkeypatch)
    assert made.stopped
    assert made.model == ("preload",)


@pytest.fixture(scope="module")
def two_found():
    """A search that took a friction, which explains half of what is explainable, and a preload beside it."""
    model, problem = problem_of("coulomb_friction", {"F_c": 1.5, "v_0": 0.003})
    base = baseline(model, problem)
    one = refit(base, model.catalogue["coulomb_friction"], problem)
    two = refit(one, model.catalogue["preload"], problem)
    half = 0.5 * (base.mse + two.mse)
    left = np.sqrt(half / one.mse) * one.fit.residual
    one = replace(one, mse=half, seen=half, fit=replace(one.fit, residual=left))
    null, floor = Null(np.zeros(0), 0.0, 1.0, 0.0, np.zeros(0)), np.sqrt(two.mse)
    rounds = [Round(b, [c], null, 0.01, c, [c.name]) for b, c in ((base, one), (one, two))]
    found = judge(
        base, two, rounds, Floor(floor, 0.0, floor, 0.0, 0.5, {}, (0.0, 0.0, 0.0)), problem
    )
    return found, problem


@pytest.mark.parametrize(("ratio", "kept"), [(0.9, 2), (1.2, 1), (1.001, 2)])
def test_what_a_search_found_last_goes_again_where_held_out_data_refuse_it(two_found, ratio, kept):
    found, problem = two_found
    names, one = ("coulomb_friction", "preload"), found.rounds[0].taken
    assert (found.effects, found.explained) == (names, pytest.approx(1.0))
    left = np.where(problem.held_out, ratio * one.fit.residual, found.best.fit.residual)
    best = replace(found.best, fit=replace(found.best.fit, residual=left))
    study = Part(diagnosis=replace(found, best=best), problem=problem)
    study, notes = veto.vetoed(study, RULE, 0.05)
    seen = study.diagnosis
    assert seen.effects == names[:kept]
    assert seen.best.fit.model.effects == (best if kept == 2 else one).fit.model.effects
    assert len(notes) == 2 - kept
    assert all(note.startswith("preload not added: the error on held-out data") for note in notes)
    if (
        kept == 1
    ):  # what remains explains less, and is judged and told by that; the next pass need not try again
        assert [c.effects for c in seen.further.candidates] == [("preload",)]
        assert seen.explained == pytest.approx(0.5)
        assert seen.verdict == "partial"
        assert "Coulomb" in " ".join(seen.reasons)
        assert "reload" not in " ".join(seen.reasons)


def test_a_search_that_was_stopped_leaves_nothing_that_held_out_data_refuse(two_found):
    found, problem = two_found
    one = found.rounds[0].taken
    left = np.where(problem.held_out, 1.2 * one.fit.residual, found.best.fit.residual)
    best = replace(found.best, fit=replace(found.best.fit, residual=left))
    stopped = replace(found, best=best, interrupted=True)
    study, notes = veto.weighed(Part(diagnosis=stopped, problem=problem), RULE, RULE, later=False)
    assert study.diagnosis.effects == ("coulomb_friction",)
    assert study.diagnosis.interrupted
    assert [note.split(":")[0] for note in notes] == ["preload not added"]


@pytest.mark.parametrize("later", [False, True])
def test_a_pass_that_was_stopped_with_what_held_out_data_refuse_is_the_last(monkeypatch, later):
    """Nothing else is fitted for whoever stopped it, and what the passes before made stays."""
    fit = SimpleNamespace(fit=SimpleNamespace(residual=np.ones(8)))
    passes = [
        Part(diagnosis=Search(("preload",), fit, (), base=fit)),
        Part(diagnosis=Search(("remanence",), fit, (), base=fit, interrupted=True)),
    ][: 1 + later]
    told = iter(passes)
    monkeypatch.setattr(improve, "investigate", lambda *_: next(told))
    monkeypatch.setattr(veto, "vetoed", lambda study, *_: (study, ()))
    monkeypatch.setattr(veto, "worse", lambda *_: "it errs")
    monkeypatch.setattr(veto, "instead", lambda *_: pytest.fail("nobody waits for it"))
    monkeypatch.setattr(improve, "refused", lambda study, rule, given: (rule, ()))
    monkeypatch.setattr(improve, "_goes_on", lambda found: later)
    made = passes_of(monkeypatch)
    assert (made.stopped, made.model) == (later, ("preload",))


@pytest.mark.parametrize(("moved", "kept"), [(1.0, 1), (0.1, 2)])
def test_what_changes_held_out_data_as_much_and_helps_only_those_it_was_fitted_to_goes_again(
    two_found, moved, kept
):
    found, problem = two_found
    one, rows = found.rounds[0].taken, problem.held_out
    left, size = found.best.fit.residual.copy(), np.sqrt(np.mean(one.fit.residual[rows] ** 2))
    turned = one.fit.residual[rows] + moved * size * np.sign(np.sin(np.arange(rows.sum())))
    left[rows] = turned * size / np.sqrt(np.mean(turned**2))
    best = replace(found.best, fit=replace(found.best.fit, residual=left))
    study, notes = veto.vetoed(
        Part(diagnosis=replace(found, best=best), problem=problem), RULE, 0.05
    )
    assert study.diagnosis.effects == ("coulomb_friction", "preload")[:kept]
    assert all(
        note.startswith("preload not added: the error on held-out data would stay")
        for note in notes
    )


def test_of_a_car_what_helps_on_held_out_data_is_told_from_all_outputs():
    """Friction moves a displacement, weighted by its noise, much more than the force that comes first."""
    train = np.arange(400) < 200
    problem = SimpleNamespace(train=train, held_out=~train, forward=SimpleNamespace(outputs=2))
    rough = np.tile([1.2, 8.0], 200) * np.repeat(np.sign(np.sin(np.arange(200.0))), 2)

    def left(residual):
        fitted = SimpleNamespace(
            residual=residual, mse=lambda rows: float(np.mean(residual[rows] ** 2))
        )
        size = fitted.mse(train)
        return SimpleNamespace(mse=size, seen=size, fit=fitted)

    assert veto.vain(problem, left(rough), left(0.1 * rough)) == ""
    turned = np.where(train, 0.1, -1.0) * rough
    assert "would stay" in veto.vain(problem, left(rough), left(turned))


def test_what_is_said_of_held_out_data_beyond_those_learnt_from_is_of_the_last_model():
    first, last = (
        f"the held-out data go beyond those learnt from: {e} N there" for e in (101, 83)
    )
    assert of_the_last(["a", first, "b"], ["c", last]) == ["a", last, "b"]
    assert of_the_last(["a", first], ["c"]) == ["a"]


NOT_ADDED = "coulomb_friction not added"


@pytest.fixture(scope="module")
def two_tied():
    """A search that took a friction, tied with another form of it."""
    model, problem = problem_of("coulomb_friction", {"F_c": 1.5, "v_0": 0.003})
    base = baseline(model, problem)
    names = ("coulomb_friction", "stribeck_friction")
    one, two = (refit(base, model.catalogue[name], problem) for name in names)
    null, floor = Null(np.zeros(0), 0.0, 1.0, 0.0, np.zeros(0)), np.sqrt(one.mse)
    rounds = [Round(base, [one, two], null, 0.01, one, list(names))]
    known = Floor(floor, 0.0, floor, 0.0, 0.5, {}, (0.0, 0.0, 0.0))
    return judge(base, one, rounds, known, problem, (names,)), problem


def erring(candidate, problem, ratio):
    """The candidate, fitted to its end, with other errors on held-out data."""
    left = np.where(problem.held_out, ratio, 1.0) * candidate.fit.residual
    return replace(candidate, fit=replace(candidate.fit, residual=left, iterations=1))


@pytest.mark.parametrize(("ratio", "taken"), [(1.0, ("stribeck_friction",)), (50.0, None)])
def test_of_tied_effects_that_one_is_taken_which_held_out_data_do_not_refuse(
    two_tied, ratio, taken
):
    found, problem = two_tied
    step, bad = found.rounds[0], erring(found.best, problem, 50.0)
    step = replace(step, candidates=[bad, erring(step.candidates[1], problem, ratio)], taken=bad)
    study = Part(diagnosis=replace(found, best=bad, rounds=(step,)), problem=problem)
    assert veto.worse(study, RULE).startswith("coulomb_friction not added: the error on held-out")
    other = veto.instead(study, RULE)
    assert (other and other.diagnosis.effects) == taken


@pytest.mark.parametrize(("ratio", "named"), [(50.0, False), (1.0, True)])
def test_the_first_effect_goes_again_too_where_held_out_data_are_predicted_worse_with_it(
    two_tied, ratio, named
):
    found, problem = two_tied
    best = erring(found.best, problem, ratio)
    study = Part(diagnosis=replace(found, best=best), problem=problem)
    study, notes = veto.weighed(study, RULE, RULE, later=False)
    seen = study.diagnosis
    assert seen.effects == (("coulomb_friction",) if named else ())
    assert [note.split(":")[0] for note in notes] == ([] if named else [NOT_ADDED])
    if not named:
        assert seen.best is seen.base
        assert seen.verdict in NOTHING_NAMED


@pytest.mark.parametrize(("one", "two", "ends"), [(50, 50, True), (50, 1, False), (1, 1, False)])
def test_no_pass_begins_with_what_held_out_data_refuse(two_tied, one, two, ends):
    found, problem = two_tied
    step = found.rounds[0]
    tried = [erring(c, problem, r) for c, r in zip(step.candidates, (one, two), strict=True)]
    further = replace(step, candidates=tried, taken=tried[0])
    study = Part(diagnosis=replace(found, further=further), problem=problem)
    rule, said = veto.refused(study, RULE, RULE)
    assert (rule is None) == bool(said) == ends
    assert all(why.startswith("coulomb_friction not added") for why in said)
    assert veto.refused(Part(diagnosis=found, problem=problem), RULE, RULE) == (RULE, ())


def test_what_held_out_data_refuse_hides_no_effect_that_they_do_not(two_tied):
    found, problem = two_tied
    step = found.rounds[0]
    bad, good = (erring(c, problem, r) for c, r in zip(step.candidates, (50, 1), strict=True))
    further = replace(step, candidates=[bad, good], taken=bad, ties=[bad.name])
    study = Part(diagnosis=replace(found, further=further), problem=problem)
    rule, said = veto.refused(study, RULE, RULE)
    assert rule.barred == {"coulomb_friction"}
    assert [why.split()[0] for why in said] == ["coulomb_friction"]
    # and what is barred already is not told again
    assert veto.refused(study, rule, RULE) == (rule, ())


@dataclass(frozen=True)
class Part:
    """A stand-in for what `improve` takes apart: a fit, a candidate, a search or a study."""

    effects: tuple[str, ...] = ()
    model: object = None
    residual: object = None
    free: tuple[tuple[str, str], ...] = ()
    fit: object = None
    best: object = None
    diagnosis: object = None
    problem: object = None
    data: object = None
    interrupted: bool = False
    rounds: tuple[SimpleNamespace, ...] = (SimpleNamespace(threshold=0.1, taken=None),)


@dataclass(frozen=True)
class Search:
    """A stand-in for what a search found."""

    effects: tuple[str, ...]
    best: object
    rounds: tuple[SimpleNamespace, ...]
    base: object = None
    verdict: str = "partial"
    explained: float = 1.0
    interrupted: bool = False
    further: object = None
    alternatives: tuple[tuple[str, ...], ...] = ()


def pruned(monkeypatch, after):
    """What is left of two searches that added a delay and a lag beside a lag of the velocity; the lag may go again."""
    problem = SimpleNamespace(
        held_out=np.ones(8, bool), force=np.arange(8.0), forward=SimpleNamespace(outputs=1)
    )
    given = load_model(GUO)
    grown = given.with_effect("force_delay").with_effect("force_lag").with_effect("velocity_lag")

    def candidate(model, left):
        return Part(fit=Part(model=model, residual=np.full(8, left)))

    def prune(found, *_):
        assert "velocity_lag" not in {*found.effects, *found.fit.model.effects}
        if isinstance(after, BaseException):
            raise after
        made = candidate(found.fit.model.without_effect("force_lag"), after)
        return replace(made, effects=tuple(e for e in found.effects if e != "force_lag"))

    study = Part(diagnosis=Part(best=candidate(grown, 1.0)), problem=problem)
    monkeypatch.setattr(improve, "prune", prune)
    monkeypatch.setattr(improve, "with_history", lambda best, *_: best)
    monkeypatch.setattr(improve, "marked", lambda model, _: model)
    level = SimpleNamespace(finished=lambda study, _: study.diagnosis.best.fit.model)
    work = SimpleNamespace(wind_up=lambda: None)
    asked = SimpleNamespace(model=given, level=level, seed=0, work=work)
    made = improve._Passes([study, study], grown)
    found = improve._together(made, asked, SimpleNamespace(digest=""), "m")
    return found, [e for e in found.model.effects if e not in given.effects]


@pytest.mark.parametrize(
    ("after", "dropped"), [(1.0, ("force_lag",)), (1.04, ("force_lag",)), (1.2, ())]
)
def test_what_became_needless_is_taken_out_unless_held_out_data_ask_for_it(
    monkeypatch, after, dropped
):
    made, added = pruned(monkeypatch, after)
    assert tuple(made.dropped) == dropped
    assert sorted(added) == sorted({"force_delay", "force_lag", "velocity_lag"} - {*dropped})
    assert ("force_lag taken out again" in " ".join(made.notes)) == bool(dropped)


def test_ctrl_c_while_effects_are_taken_out_keeps_what_was_done(monkeypatch):
    made, added = pruned(monkeypatch, KeyboardInterrupt())
    assert made.stopped
    assert sorted(added) == ["force_delay", "force_lag", "velocity_lag"]


def test_the_summary_of_a_pass_tells_the_same_and_holds_no_derivatives_but_of_what_was_taken():
    model, problem = problem_of("preload", {"F_0": 4.0})
    found = search_effects(model, problem, seed=1)
    study = Study(asked(model, problem), found)
    short = summary(study)
    assert entries(short, found.model) == entries(study, found.model)
    stopped = replace(study, diagnosis=replace(found, interrupted=True))
    (taken, *others), known = entries(stopped, found.model), entries(study, found.model)
    assert taken == known[0]
    assert others
    for other, sure in zip(others, known[1:], strict=True):
        values, sds, _ = zip(*other["parameters"].values(), strict=True)
        assert not np.isfinite(sds).any(), "nobody waits for deviations after an interruption"
        assert values == tuple(v for v, _, _ in sure["parameters"].values())
    kept = {
        c.name for step in short.diagnosis.rounds for c in step.candidates if c.fit.jacobian.size
    }
    assert kept == {"preload"} == set(found.effects)
    assert short.diagnosis.best is found.best
    assert short.diagnosis.further is None

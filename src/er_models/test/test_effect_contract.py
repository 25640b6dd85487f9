"""What every effect of the catalogue must be; being listed is being tested."""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import itertools
import math
import pkgutil
from collections.abc import Callable

import er_models.catalogue
import numpy as np
import pytest
from er_models.cards.symbols import ACTS
from er_models.catalogue import CATALOGUE
from er_models.effect import HOOKS, SIGNALS, SMOOTH, Effect
from er_models.kernel.order import KNOWN_FROM, OF_STATE, ORDER, OUTSIDE, signals_of
from er_models.model import Array, Model
from er_models.prediction import Motion, predict, predict_many
from er_models.scales import Scales
from er_models.simulation import simulate
from models_help import (
    DT,
    LARGE,
    SMALL,
    bingham,
    box,
    car,
    guo,
    imposed,
    neutral,
    one_sample,
    started,
    typical,
)
from reference import sensitivities

from er_models import own_check

EFFECTS = pytest.mark.parametrize("effect", CATALOGUE.effects, ids=lambda e: e.name)
BEYOND = tuple(e for e in CATALOGUE.effects if e.stage not in ("core", "vehicle"))
ADDED = pytest.mark.parametrize("effect", BEYOND, ids=lambda e: e.name)
SCALES = pytest.mark.parametrize("scales", [SMALL, LARGE], ids=("20 N", "2000 N"))


def base(scales: Scales, *names: str) -> Model:
    """A dynamic Guo damper of these scales."""
    return started(scales, *(names or ("passive", "guo_yield", "response")))


def test_every_module_of_the_folders_is_listed() -> None:
    """A file that nobody lists would silently do nothing."""
    found = set()
    for package in pkgutil.iter_modules(er_models.catalogue.__path__):
        folder = importlib.import_module(f"er_models.catalogue.{package.name}")
        for module in pkgutil.iter_modules(folder.__path__):
            effect = importlib.import_module(f"{folder.__name__}.{module.name}").EFFECT
            assert effect.name == module.name
            assert effect.stage == package.name
            found.add(effect.name)
    assert found == set(CATALOGUE.names)


@EFFECTS
def test_describes_itself(effect: Effect) -> None:
    s = effect.signature
    texts = [effect.title, effect.physics, effect.source, s.mark, s.plane, s.experiment]
    assert all(len(text) > 3 for text in texts)
    assert all(q.meaning for q in effect.parameters)
    assert effect.hooks
    assert all(function.__doc__ for function in effect.hooks.values())
    assert set(s.rivals) <= set(CATALOGUE.names) - {effect.name}
    assert effect.knowable or effect.unknowable_because


@EFFECTS
def test_starts_lie_in_bounds_and_units_have_scales(effect: Effect) -> None:
    for q in effect.parameters:
        assert q.low < q.high
        assert q.starts
        assert all(q.low <= start <= q.high for start in q.starts)
        assert q.neutral is None or q.neutral == math.inf or q.low <= q.neutral <= q.high
        for scales in (SMALL, LARGE):
            assert scales.of(q.unit) > 0.0


@pytest.mark.parametrize(
    "effect", [e for e in CATALOGUE.effects if e.stage != "core"], ids=lambda e: e.name
)
def test_has_a_value_at_which_it_vanishes(effect: Effect) -> None:
    assert any(q.neutral is not None for q in effect.parameters)


@EFFECTS
def test_hooks_ask_for_what_is_known_where_they_act(effect: Effect) -> None:
    for hook, function in effect.hooks.items():
        known = (*effect.names, *signals_of(effect, hook))
        assert set(inspect.signature(function).parameters) <= set(known), hook


def test_every_hook_has_its_place_and_its_sign() -> None:
    between = {"response", "states", "late"}
    assert {*ORDER, *OUTSIDE, *OF_STATE} - between == set(HOOKS)
    assert ACTS.keys() == HOOKS.keys()


def test_what_a_users_hook_leaves_as_it_is_follows_from_its_sign() -> None:
    """Else a user's effect that does nothing would be refused, or one that does something let in."""
    signs = {hook: plain.split()[-1] for hook, (plain, _) in ACTS.items()}
    assert own_check._MAPPED.keys() == {hook for hook, sign in signs.items() if sign == ":="}
    assert set(own_check._SCALING) == {hook for hook, sign in signs.items() if sign == "*="}


def test_every_signal_is_known_somewhere_and_has_a_scale() -> None:
    outside = {name for names in OUTSIDE.values() for name in names}
    assert KNOWN_FROM.keys() | outside == SIGNALS.keys()
    assert all(SMALL.of(signal.unit) > 0.0 for signal in SIGNALS.values())


def test_candidates_are_what_a_damper_can_show() -> None:
    names = {e.name for e in CATALOGUE.candidates()}
    unknowable = {e.name for e in CATALOGUE.unknowable()}
    assert unknowable >= {"force_gain", "velocity_gain", "duty_gain"}
    faults = {e.name for e in CATALOGUE.effects if e.stage == "fault"}
    assert names == {e.name for e in BEYOND} - unknowable - faults


@EFFECTS
def test_cannot_be_changed(effect: Effect) -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        effect.name = "other"  # type: ignore[misc]
    with pytest.raises(dataclasses.FrozenInstanceError):
        effect.parameters[0].low = 0.0  # type: ignore[misc]


@SCALES
@ADDED
@pytest.mark.parametrize("dynamic", [True, False], ids=("dynamic", "static"))
def test_neutral_gives_exactly_nothing(effect: Effect, scales: Scales, dynamic: bool) -> None:
    core = ("passive", "guo_yield", *(("response",) if dynamic else ()))
    model, inputs = base(scales, *core), imposed(scales, 1.0)
    without, with_it = predict(model, inputs), predict(neutral(model, effect), inputs)
    assert np.abs(with_it - without).max() <= 1e-12 * scales.force


@ADDED
def test_neutral_gives_exactly_nothing_in_the_car(effect: Effect) -> None:
    road = 0.004 * np.sin(2.0 * np.pi * 4.0 * np.arange(100) * DT)
    duty = np.repeat([0.1, 0.3], 50)
    without, with_it = (simulate(m, DT, road, duty) for m in (car(), neutral(car(), effect)))
    for channel, values in without.items():
        assert np.abs(with_it[channel] - values).max() <= 1e-9 * np.abs(values).max() + 1e-15


@SCALES
@ADDED
def test_has_an_effect(effect: Effect, scales: Scales) -> None:
    model, inputs = base(scales), imposed(scales, 3.0)
    change = predict(typical(model, effect), inputs) - predict(model, inputs)
    assert change.std() + abs(change.mean()) > 1e-3 * scales.force


@SCALES
@EFFECTS
def test_is_finite_over_its_whole_box(effect: Effect, scales: Scales) -> None:
    inputs = imposed(scales, 0.5)
    for values in box(effect, scales):
        model = base(scales).with_effect(effect.name, values)
        force = predict(model, inputs)
        assert np.isfinite(force).all(), values


@pytest.mark.parametrize(
    "effect",
    [e for e in CATALOGUE.effects if e.stage == "force" and not e.has_state],
    ids=lambda e: e.name,
)
def test_dissipates_as_declared(effect: Effect) -> None:
    """Declared where it only takes energy, over the whole box, and nowhere else: a forgotten flag is seen too."""
    inputs = imposed(SMALL, 2.0)
    model = started(SMALL, "passive").with_effect("passive", {"k0": 0.0})
    taken = [
        float((predict(model.with_effect(effect.name, values), inputs) * inputs.v).min())
        for values in box(effect, SMALL)
    ]
    assert (min(taken) >= -1e-12) == effect.dissipative, min(taken)


POSITIVE = {"k_0": 500.0, "c_0": 100.0, "tau_y": 0.03, "tau_scale": 1.0, "w": 0.0}
"""Signals that are not signed; others are tried at half and all of the envelope, to either side."""
SLOW = 1.0
"""Rate below which a state has no time to settle before a record begins [1/s]."""


def _relaxations(effect: Effect, values: dict[str, float]) -> list[tuple[float, float]]:
    """(rate, drive) of an effect's state all over the envelope of a damper, with these values in place of starts."""
    hook, model = effect.hooks["relax"], started(SMALL).with_effect(effect.name, values)
    levels = []
    for name in inspect.signature(hook).parameters:
        if name in effect.names:
            levels.append([model.value(effect.name, name)])
        elif name in POSITIVE:
            levels.append([POSITIVE[name]])
        else:
            size = SMALL.of(SIGNALS[name].unit)
            levels.append([share * size for share in (-1.0, -0.5, 0.5, 1.0)])
    return [hook(*point) for point in itertools.product(*levels)]  # type: ignore[misc]


STATES = [e for e in CATALOGUE.effects if e.has_state]


@pytest.mark.parametrize("effect", STATES, ids=lambda e: e.name)
def test_a_state_that_cannot_have_settled_begins_at_rest(effect: Effect) -> None:
    """One that may integrate or be slow has no equilibrium with the first sample; others have, perhaps at a bound."""
    edges = [
        {q.name: bound * SMALL.of(q.unit)} for q in effect.parameters for bound in (q.low, q.high)
    ]
    slow = "bound" not in effect.hooks and any(
        rate < SLOW and drive != 0.0
        for values in ({}, *edges)
        for rate, drive in _relaxations(effect, values)
    )
    assert effect.initial == ("zero" if slow else "equilibrium")


@pytest.mark.parametrize(
    "effect", [e for e in STATES if e.initial == "zero"], ids=lambda e: e.name
)
def test_what_begins_at_rest_leaves_the_first_sample_alone(effect: Effect) -> None:
    model, first = base(SMALL), one_sample(0.0, 2.0 * SMALL.velocity, SMALL.duty)
    assert predict(typical(model, effect), first) == predict(model, first)


def _scaled(inputs: Motion, scales: Scales, reference: Scales) -> Motion:
    """A motion of one damper as the same motion of another, in the same time."""
    ratio = scales.deflection / reference.deflection
    assert scales.velocity / reference.velocity == pytest.approx(ratio)
    return dataclasses.replace(
        inputs,
        x=inputs.x * ratio,
        v=inputs.v * ratio,
        a=inputs.a * ratio,
        u=inputs.u * scales.duty / reference.duty,
    )


@ADDED
def test_starts_mean_the_same_for_every_damper(effect: Effect) -> None:
    """The declaration has no size of its own: a damper 5 times as long gives the same curve, scaled."""
    scales = Scales(1000.0 * SMALL.force, 5.0 * SMALL.deflection, 5.0 * SMALL.velocity, 1.0)
    inputs = imposed(SMALL, 1.0)

    def shape(s: Scales, record: Motion) -> Array:
        return predict(typical(base(s), effect), record) / s.force

    small, large = shape(SMALL, inputs), shape(scales, _scaled(inputs, scales, SMALL))
    assert np.abs(large - small).max() < 1e-6


@ADDED
def test_one_prediction_is_each_of_many(effect: Effect) -> None:
    """What the batch over all cores computes is, to the last bit, what one prediction computes."""
    model, inputs = typical(base(SMALL), effect), imposed(SMALL, 0.5)
    points = [{**model.effects[effect.name], **values} for values in box(effect, SMALL)[:3]]
    models = [model.with_effect(effect.name, values) for values in points]
    many = predict_many(model, np.array([m.compiled().p for m in models]), inputs)
    for row, one in zip(many, models):
        assert np.array_equal(row, predict(one, inputs))


def _runs(model: Model) -> Callable[[Array], Array]:
    """Outputs (m, n) of flat parameter vectors: the force along a motion, or readings of the car on a road."""
    if not model.is_vehicle:
        inputs = imposed(SMALL, 2.0)
        return lambda vectors: predict_many(model, vectors, inputs)
    t = np.arange(300) * DT
    road = 2.0 * SMALL.deflection * (np.sin(11.0 * t) + 0.3 * np.sin(100.0 * t))
    duty = SMALL.duty * np.repeat([0.2, 0.8], 150)

    def readings(vectors: Array) -> Array:
        out = []
        for p in vectors:
            of = {e: {n: p[CATALOGUE.column(e, n)] for n in v} for e, v in model.effects.items()}
            run = simulate(dataclasses.replace(model, effects=of), DT, road, duty)
            channels = ("sprung_acceleration", "unsprung_acceleration", "deflection")
            out.append(np.concatenate([run[c] / np.std(run[c]) for c in channels]))
        return np.array(out)

    return readings


@EFFECTS
def test_derivatives_by_its_parameters_are_central_differences(effect: Effect) -> None:
    """At random points near each start; where a value moves jumps, a secant on one side instead."""
    rng = np.random.default_rng(7)
    car = ("quarter_car",) if effect.stage == "vehicle" else ()
    for which in range(max(len(q.starts) for q in effect.parameters)):
        model = base(SMALL, "passive", "guo_yield", "response", *car)
        values = {q.name: model.start(effect.name, q.name, which) for q in effect.parameters}
        off = {n: v * rng.uniform(0.9, 1.1) for n, v in values.items()}
        model = model.with_effect(effect.name, off)
        parameters = [(effect.name, q.name) for q in effect.parameters]
        rows = _runs(model)
        here, slopes = sensitivities(model, parameters, rows)
        for q, slope in zip(effect.parameters, slopes.T, strict=True):
            if effect.stage == "fault" and not q.fitted:
                continue  # instants of jumps, given and never fitted
            smooth, size = q.step == SMOOTH, q.size * SMALL.of(q.unit)
            step = 3e-5 * size if smooth else q.step * max(abs(off[q.name]), 0.1 * size)
            if not smooth and off[q.name] + step > q.high * SMALL.of(q.unit):
                step = -step  # into the box
            vectors = np.tile(model.compiled().p, (2, 1))
            vectors[:, CATALOGUE.column(effect.name, q.name)] += (step, -step if smooth else 0.0)
            after, before = rows(vectors)
            expected = (after - before) / (2.0 * step if smooth else step)
            error = np.linalg.norm(slope - expected)
            assert error <= 1e-5 * np.linalg.norm(expected) + 1e-9 * np.linalg.norm(here) / size, q


@pytest.mark.parametrize("model", [guo(), bingham()], ids=("guo", "bingham"))
def test_all_effects_at_once_are_finite(model: Model) -> None:
    for effect in CATALOGUE.candidates():
        model = typical(model, effect)
    assert np.isfinite(predict(model, imposed(model.scales, 2.0))).all()

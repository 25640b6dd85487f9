"""Gain files: written and read back, and refused in one line whenever they prove nothing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from er_models.errors import InputError
from er_models.gain_file import digest
from er_models.model import Model
from er_observers.forms import form_of
from er_observers.gains import Gains, observer_of, save_gains
from er_observers.observers.status import LIMITS
from er_observers.observers.watch import decay_rate, rules_of, watch_of
from er_observers.programs import OBSERVERS
from er_observers.running.evaluate import SCENARIOS, evaluate
from er_observers.running.ready import ready
from er_observers.synthesis.certify import Certificate
from er_observers.synthesis.proof import Claim

Made = tuple[Claim, Certificate]
REMAKE = (
    "the committed gains no longer fit the committed model; make them again:\n"
    "python -m er_observers.synth nlpv_polytopic --model config/vehicles/inove_quarter_car.yaml"
    " --out config/gains/nlpv_polytopic.yaml"
)


def write(path: Path, car: Model, made: Made) -> None:
    """A gain file as the command writes it."""
    save_gains(path, "nlpv_polytopic", car, *made)


def refusal(path: Path, car: Model) -> str:
    """The one line of the refusal."""
    with pytest.raises(InputError) as error:
        ready(path, car, "nlpv_polytopic")
    text = str(error.value)
    assert "\n" not in text
    assert str(path) in text
    assert error.value.exit_status == 2
    return text


@pytest.mark.parametrize("deflection", [False, True])
def test_a_car_without_passive_damping_can_be_watched(car: Model, *, deflection: bool) -> None:
    """Its gains were written and could not be loaded: the sprung acceleration tells the deflection at once."""
    undamped = {**car.effects, "passive": {**car.effects["passive"], "c0": 0.0}}
    form = form_of(replace(car, effects=undamped), deflection=deflection)
    watch = watch_of(form, np.array([-300.0, -20.0]))
    rules = rules_of(watch, LIMITS)
    assert 0.0 < watch.noise_gain < 1.0
    assert decay_rate(rules, 0.0, 1.0) == watch.pace == 20.0
    assert (0.0 < decay_rate(rules, 1.0, 1.0) < 20.0) is not deflection


def test_committed_gains_fit_the_committed_model(
    car: Model, gain_file: Path, synthesis: Made
) -> None:
    """They load, and a new synthesis promises the same.

    Gains themselves may differ in flat directions of the optimum from one processor to another.
    """
    try:
        gains = ready(gain_file, car, "nlpv_polytopic")
    except InputError as error:
        pytest.fail(f"{REMAKE}\n({error})")
    fresh = synthesis[0].solution
    assert gains.claim.spec.noise == synthesis[0].spec.noise, REMAKE
    assert gains.claim.solution.gamma == pytest.approx(fresh.gamma, rel=2e-3), REMAKE
    assert gains.watch.pace == pytest.approx(-synthesis[1].poles.real.max(), rel=0.02), REMAKE


def test_round_trip_is_exact(car: Model, synthesis: Made, tmp_path: Path) -> None:
    """What is read is what was proved, bit by bit; writing again gives the same file."""
    first, second = tmp_path / "a.yaml", tmp_path / "b.yaml"
    write(first, car, synthesis)
    write(second, car, synthesis)
    assert first.read_bytes() == second.read_bytes()
    claim = ready(first, car, "nlpv_polytopic").claim
    np.testing.assert_array_equal(claim.solution.L, synthesis[0].solution.L)
    np.testing.assert_array_equal(claim.solution.P, synthesis[0].solution.P)
    assert claim.spec.rho == synthesis[0].spec.rho


def test_model_with_other_matrices_is_refused(car: Model, gain_file: Path) -> None:
    """One gram more, and the file says whose gains it holds and how to make others."""
    effects = {name: dict(values) for name, values in car.effects.items()}
    effects["quarter_car"]["m_s"] += 0.001
    text = refusal(gain_file, replace(car, effects=effects))
    assert "model.fingerprint" in text
    assert "python -m er_observers.synth nlpv_polytopic" in text


def test_name_and_envelope_of_the_model_do_not_matter(car: Model, gain_file: Path) -> None:
    """Gains belong to matrices."""
    assert (
        ready(gain_file, replace(car, name="renamed", rig={}), "nlpv_polytopic").model == "renamed"
    )


def _scale(section: str, key: str, factor: float) -> Callable[[dict[str, Any]], None]:
    def edit(content: dict[str, Any]) -> None:
        data = content[section][key]["data"]
        content[section][key]["data"] = [factor * v for v in data]

    return edit


def _set(section: str, key: str, value: object) -> Callable[[dict[str, Any]], None]:
    def edit(content: dict[str, Any]) -> None:
        content[section][key] = value

    return edit


@pytest.mark.parametrize(
    ("edit", "sealed", "named"),
    [
        (_scale("law", "L", 1.001), False, "digest"),
        (_set("solution", "gamma", 1.0), False, "digest"),
        (_set("certificate", "slowest", -5.0), False, "digest"),
        (_scale("law", "L", -1.0), True, "solution"),
        (_set("solution", "gamma", 1.0), True, "dissipation"),
        (_scale("solution", "P", 0.5), True, "solution"),
        (_set("solution", "multipliers", [-1.0, -1.0]), True, "multiplier"),
        (_set("solution", "gamma", float("nan")), True, "solution.gamma"),
        (_set("law", "L", {"shape": [2, 2, 2], "data": [0.0] * 8}), True, "law.L"),
        (_set("solution", "P", {"shape": [4, 4], "data": [1.0] * 3}), True, "solution.P"),
        (_set("spec", "rho", [1.0, 0.0]), True, "spec.rho"),
        (_set("spec", "sector", "circle"), True, "spec.sector"),
        (_set("spec", "noise", [0.1]), True, "spec.noise"),
        (_set("scaling", "state", [1.0, 1.0, 1.0, 0.0]), True, "scaling.state"),
        (_set("certificate", "discrete", {"substep": 1e-5}), True, "substep"),
        (_set("certificate", "discrete", {"substep": 1.25e-3, "duties": 2}), True, "duties"),
    ],
)
def test_edited_files_are_refused(
    car: Model,
    gain_file: Path,
    tmp_path: Path,
    edit: Callable[[dict[str, Any]], None],
    sealed: bool,
    named: str,
) -> None:
    """By the digest, and where that was made to fit as well, by the inequalities."""
    content = yaml.safe_load(gain_file.read_text(encoding="utf-8"))
    edit(content)
    if sealed:
        content["digest"] = digest(content)
    path = tmp_path / "edited.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    assert named in refusal(path, car)


def test_what_is_no_gain_file_is_refused(car: Model, gain_file: Path, tmp_path: Path) -> None:
    """Missing, folder, broken YAML, another kind of file, unknown key, missing section."""
    content = yaml.safe_load(gain_file.read_text(encoding="utf-8"))
    cases: dict[str, tuple[str | None, str]] = {
        "missing": (None, "no file"),
        "broken": ("a: [1", "YAML"),
        "list": ("- 1", "mapping"),
        "schema": (yaml.safe_dump({**content, "schema": "er_model 1"}), "er_gains 1"),
        "observer": (yaml.safe_dump({**content, "observer": "unified"}), "nlpv_polytopic"),
        "key": (yaml.safe_dump({**content, "extra": 1}), "unknown key"),
    }
    for name, (text, expected) in cases.items():
        path = tmp_path / f"{name}.yaml"
        if text is not None:
            path.write_text(text, encoding="utf-8")
        assert expected in refusal(path, car)
    assert "a folder" in refusal(tmp_path, car)


def test_the_gains_of_a_controller_are_called_that(gain_file: Path) -> None:
    """Both lie in one folder; the kind expected and the kind found are named."""
    with pytest.raises(
        InputError,
        match=r"lpv_ftc\.yaml: schema: .*gain file of an observer, found that of 'lpv_ftc'",
    ):
        observer_of(gain_file.with_name("lpv_ftc.yaml"))
    with pytest.raises(InputError, match="found 'er_scenario 1'"):
        observer_of(gain_file.parent.parent / "scenarios" / "chapter_5_step.yaml")
    assert observer_of(gain_file) == "nlpv_polytopic"


def test_gains_carry_what_the_loop_needs(gains: Gains) -> None:
    """Matrices of the kernel reproduce A - L C at both ends."""
    M, J, size = (gains.plan.part(name) for name in ("M", "J", "size"))
    for k, L in enumerate(gains.claim.solution.L):
        whole = M[k] * size[:, None] / size
        np.testing.assert_allclose(whole, gains.form.A - L @ gains.form.C, rtol=1e-9, atol=1e-6)
        np.testing.assert_allclose(J[k] * size[:, None], L, rtol=1e-9)


@pytest.mark.parametrize("name", OBSERVERS)
def test_every_committed_observer_follows_the_force(
    car: Model, gain_file: Path, name: str
) -> None:
    """The three gain files fit the model; each is below half a per cent on a rough road."""
    gains = ready(gain_file.parent / f"{name}.yaml", car, name)
    score = evaluate(car, gains, SCENARIOS[5])
    assert score.nrmse < 0.005
    assert score.first_ok is not None
    assert score.first_ok < 0.5


def test_a_law_whose_error_follows_the_state_is_refused(
    car: Model, gain_file: Path, tmp_path: Path
) -> None:
    """The unified observer rests on identities; an edited matrix breaks them, sealed or not."""
    file = gain_file.parent / "unified.yaml"
    content = yaml.safe_load(file.read_text(encoding="utf-8"))
    content["law"]["J"]["data"] = [1.01 * v for v in content["law"]["J"]["data"]]
    content["digest"] = digest(content)
    path = tmp_path / "edited.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    with pytest.raises(InputError, match="a residual of"):
        ready(path, car, "unified")

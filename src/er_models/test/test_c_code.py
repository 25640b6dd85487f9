"""C code of models, compiled, against the kernel that it was written from."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import er_models.prediction
import numpy as np
import pytest
from c_help import library, needs_compiler, run
from er_models.catalogue import CATALOGUE, Catalogue
from er_models.effect import Effect
from er_models.errors import ErError
from er_models.export.c_code import CCode
from er_models.files import load_model
from er_models.model import Model
from er_models.own import effects
from er_models.prediction import Motion, motion, predict
from er_models.shipped import names
from models_help import DT, LARGE, SMALL, guo, imposed, span, started
from plain_kernel import plain_kernel

CLOSE = 1e-9
"""Largest difference to the kernel as a share of the range of the force."""
LATE = {"dead_time": {"T_d": 2.46 * DT}, "force_delay": {"d": 2.46 * DT}}
"""Delays of more than a sample and of no whole number of them."""


def alone(effect: Effect) -> Model:
    """A damper with one effect of the catalogue."""
    model = (
        guo()
        if effect.name in guo().effects
        else guo().with_effect(effect.name, LATE.get(effect.name))
    )
    return replace(model, name=f"with_{effect.name}")


def crowd() -> Model:
    """A large damper with nearly everything at once."""
    core = ("passive_by_direction", "guo_yield", "response_table", "piston_play", "dead_time")
    more = (
        "cavitation",
        "end_stop",
        "bouc_wen_hysteresis",
        "rise_fall_asymmetry",
        "self_heating",
        "velocity_lag",
    )
    return replace(started(LARGE, *core, *more, "force_lag", "force_delay"), name="crowd").with_effect(
        "force_delay", {"d": 3.0 * DT}
    )  # fmt: skip


def warm(inputs: Motion) -> Motion:
    """The same motion while it gets warmer."""
    return replace(inputs, theta=np.linspace(0.0, 20.0, inputs.n))


ALONE = {f"with_{e.name}": alone(e) for e in CATALOGUE.effects if e.stage != "vehicle"}
SHIPPED = {n: load_model(n) for n in names("dampers", "vehicles")}
AT_ONCE = replace(ALONE["with_dead_time"].without_effect("response"), name="at_once")
"""A dead time before a force that jumps with the duty."""
MODELS = SHIPPED | ALONE | {"crowd": crowd(), "at_once": AT_ONCE}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """All models in one library."""
    return library(list(MODELS.values()), tmp_path_factory.mktemp("c"))


@needs_compiler
@pytest.mark.parametrize("name", [*SHIPPED, *ALONE])
def test_the_force_is_that_of_the_kernel(name: str, made: ctypes.CDLL) -> None:
    model = MODELS[name]
    inputs = warm(imposed(model.scales, 1.5))
    expected = predict(model, inputs)
    assert np.abs(run(made, model, inputs) - expected).max() < CLOSE * span(expected)


@needs_compiler
@pytest.mark.parametrize("name", ["with_dead_time", "with_force_delay", "at_once"])
def test_a_delay_of_whole_samples_and_other_rates(name: str, made: ctypes.CDLL) -> None:
    for dt in (LATE["dead_time"]["T_d"] / 2.0, 1e-3, 0.4e-3):
        inputs = imposed(MODELS[name].scales, 0.5, dt)
        expected = predict(MODELS[name], inputs)
        assert np.abs(run(made, MODELS[name], inputs) - expected).max() < CLOSE * span(expected)


@needs_compiler
@pytest.mark.parametrize("dt", [DT, 1e-3])
def test_many_effects_at_once(
    dt: float, made: ctypes.CDLL, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Against the kernel as Python runs it, which rounds as C does.

    Where several states jump and feed back through one another, the compiled one, which contracts products and
    sums, ends its search elsewhere within the tolerance: up to 1e-5 of the range.
    """
    kernel = plain_kernel(CATALOGUE)
    monkeypatch.setattr(er_models.prediction, "kernel", lambda _: kernel)
    inputs = warm(imposed(LARGE, 60 * dt, dt))
    expected = predict(crowd(), inputs)
    assert np.abs(run(made, crowd(), inputs) - expected).max() < CLOSE * span(expected)


@needs_compiler
def test_steps_of_any_length_tell_the_time_and_keep_the_dead_time(made: ctypes.CDLL) -> None:
    """At constant velocity a step is exact whatever its length, but for where the duty is asked to change."""
    steps = np.tile([0.25e-3, 1.0e-3, 0.5e-3, 0.25e-3], 100)
    t = np.concatenate([[0.0], np.cumsum(steps)])
    duty = np.where(t < 0.1, 0.0, 0.2)
    v = np.full(t.size, 0.05)
    given = replace(motion(1e-3, 0.0 * t, v, duty, 0.0 * t), x=0.05 * t)
    fine = 0.25e-3 * np.arange(round(t[-1] / 0.25e-3) + 1)
    inputs = motion(
        0.25e-3, 0.05 * fine, 0.05 + 0.0 * fine, np.where(fine < 0.1, 0.0, 0.2), 0.0 * fine
    )
    for name in ("with_dead_time", "with_effectiveness_fade", "with_force_delay"):
        expected = predict(MODELS[name], inputs)[np.rint(t / 0.25e-3).astype(int)]
        found = run(made, MODELS[name], given, steps)
        assert np.abs(found - expected).max() < 1e-4 * span(expected)


def test_the_code_holds_the_effects_of_the_model_alone() -> None:
    text = "".join(CCode(guo()).files.values())
    assert "guo_yield" in text
    assert "coulomb" not in text
    assert "waiting" not in text
    assert "malloc" not in text
    assert "waiting" in "".join(CCode(MODELS["with_dead_time"]).files.values())


@needs_compiler
def test_parameters_are_the_models_and_may_be_changed(made: ctypes.CDLL) -> None:
    code, values = CCode(guo()), (ctypes.c_double * 6)()
    made.inove_guo_defaults(values)
    assert dict(zip([s.name for s in code.slots], values, strict=True)) == {
        f"{e}.{q}": v for e, own in guo().effects.items() for q, v in own.items()
    }
    state = ctypes.create_string_buffer(1 << 12)
    force = made.inove_guo_init
    force.restype = ctypes.c_double
    at = [ctypes.c_double(v) for v in (0.01, 0.0, 0.0, 0.0, 0.0)]
    values[0] = 1000.0
    assert force(state, values, *at) == pytest.approx(10.0)


OWN = '''"""Effects of a user."""
import math
import numpy as np
from er_models.effect import Effect, Param, Signature

TURNS = 3


def series(x: float) -> float:
    """A sum with everything that may be written."""
    total, k = 0.0, 1
    for i in range(TURNS):
        if i == 1 and not x < 0.0:
            continue
        total += x ** (i + 1) / (1 + i) if 0.0 <= abs(x) < 1.0 else math.copysign(1.0, x)
        k *= 2
    while k > 4:
        k -= 3
    return total * k + math.pi * np.sin(x) % 0.7 + (x // 0.3)


def relax(T: float, v: float, theta: float) -> tuple[float, float]:
    rate = 1.0 / max(T, 1e-6)
    if v > 0.0:
        return 2.0 * rate, rate * (v + 0.1 * theta)
    return rate, rate * (v + 0.1 * theta)


def force(K: float, x: float, w: float, theta: float) -> float:
    pass  # more
    return K * (series(100.0 * x) + w) + 0.01 * theta


EFFECT = Effect(
    name="mine", stage="force", title="Mine", physics="Of the user. Known to nobody else.",
    parameters=(Param("K", "N", -2.0, 2.0, 0.0, (0.05,), "size"), Param("T", "s", 0.0, 1.0, None, (0.01,), "lag")),
    hooks={"relax": relax, "force": force},
    signature=Signature(mark="odd", plane="force-deflection", experiment="any"), source="own",
)
'''


def own(folder: Path, line: str) -> Model:
    """A damper with an effect of a user's file."""
    (folder / "mine.py").write_text(OWN.replace("pass  # more", line))
    catalogue: Catalogue = effects([folder / "mine.py"])
    return replace(guo(), catalogue=catalogue, name="own").with_effect("mine")


@needs_compiler
def test_an_effect_of_a_users_file_with_helpers_loops_and_ways_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = own(tmp_path, "pass")
    kernel = plain_kernel(model.catalogue)
    monkeypatch.setattr(er_models.prediction, "kernel", lambda _: kernel)
    inputs = warm(imposed(SMALL, 0.3))
    expected = predict(model, inputs)
    assert np.abs(run(library([model], tmp_path), model, inputs) - expected).max() < CLOSE * span(
        expected
    )
    without = predict(model.without_effect("mine"), inputs)
    assert np.abs(expected - without).max() > 1e-3 * span(expected)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("K = np.interp(x, np.array([0.0, 1.0]), np.array([K, K]))", r"mine\.py:\d+, force: the function `np.interp`"),
        ("for y in (1.0, 2.0): K = K * y", r"mine\.py:\d+, force: a loop over anything but a range has no form in C"),
    ],
)  # fmt: skip
def test_what_has_no_form_in_c_is_one_line(line: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(ErError, match=said) as told:
        _ = CCode(own(tmp_path, line)).files
    assert "\n" not in str(told.value)


@needs_compiler
def test_the_header_is_c_plus_plus_as_well(tmp_path: Path) -> None:
    compiler = shutil.which("c++") or shutil.which("g++")
    if compiler is None:
        pytest.skip("no C++ compiler here")
    header = CCode(crowd()).files["crowd.h"]
    (tmp_path / "crowd.hpp").write_text(header)
    words = [compiler, "-Wall", "-Werror", "-fsyntax-only", str(tmp_path / "crowd.hpp")]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")

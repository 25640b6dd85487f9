"""What `import er_models` gives: named once, documented, there when it is asked for and not before."""

from __future__ import annotations

import ast
import inspect
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from er_models.errors import InputError
from er_models.model import Model
from models_help import CONFIG, DT, SMALL

import er_models

NAMES: list[str] = er_models.__all__  # type: ignore[attr-defined]


def test_types_know_every_name_and_no_other() -> None:
    tree = ast.parse(Path(er_models.__file__).read_text(encoding="utf-8"))
    (block,) = (n for n in tree.body if isinstance(n, ast.If))
    seen = [a for n in block.body if isinstance(n, ast.ImportFrom) for a in n.names]
    assert all(a.asname == a.name for a in seen), "else it is not exported to who checks types"
    assert sorted(a.name for a in seen) == NAMES == dir(er_models)


@pytest.mark.parametrize("name", [n for n in NAMES if n != "__version__"])
def test_every_name_says_what_it_is(name: str) -> None:
    thing = getattr(er_models, name)
    said = inspect.getdoc(thing)
    assert said
    assert not said.startswith(f"{name}("), "a dataclass that only lists its fields"
    if inspect.isfunction(thing):
        assert "return" in thing.__annotations__
        assert "[" in said or "Raises" in said or "catalogue" in said.lower(), "units, or errors"


def test_the_package_itself_loads_nothing() -> None:
    """What a node or a command imports of it pays for that alone."""
    script = "import sys; before = set(sys.modules); import er_models; print(*set(sys.modules) - before)"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    ours = {m for m in done.stdout.split() if m.startswith("er_models")}
    assert ours == {"er_models", "er_models.lazy"}
    assert not {"numpy", "numba", "scipy", "yaml"} & set(done.stdout.split())


def test_a_name_that_is_not_there_is_an_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'predictt'"):
        getattr(er_models, "predictt")  # noqa: B009


def test_the_example_of_its_page() -> None:
    model = er_models.load_model(CONFIG / "dampers" / "inove_guo.yaml")
    t = np.arange(200) * DT
    x, v = 0.005 * np.sin(9.0 * t), 0.045 * np.cos(9.0 * t)
    inputs = er_models.motion(DT, x, v, np.full(200, 0.1))
    worn = model.with_effect("coulomb_friction", {"F_c": 1.0, "v_0": 0.003})
    more = er_models.predict(worn, inputs) - er_models.predict(model, inputs)
    assert more == pytest.approx(np.tanh(v / 0.003), abs=1e-9)
    both = er_models.predict(worn, er_models.join([inputs, inputs]))
    assert np.array_equal(both[:200], both[200:])
    car = er_models.load_model(CONFIG / "vehicles" / "inove_quarter_car.yaml")
    road = er_models.road_profile({"kind": "iso8608", "road_class": "C", "speed": 15.0}, t)
    record = er_models.simulate(car, DT, 0.2 * road, np.full(200, 0.1))
    assert record["damper_force"].shape == (200,)
    form = er_models.linearise(car)
    assert np.linalg.eigvals(form.frozen(0.1, 0.0)).real.max() < 0.0


def test_the_catalogue_is_a_list_by_name() -> None:
    known = er_models.effects()
    assert [e.name for e in known] == list(known.names)
    assert len(known) == len(known.names)
    assert known["preload"].title.startswith("Preload")
    assert repr(known) == f"<catalogue of {len(known)} effects>"
    with pytest.raises(er_models.UnknownName, match="did you mean preload"):
        known["prelod"]


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"v": np.zeros(3)}, r"motion: v: expected 4 samples, as x, found shape \(3,\)"),
        ({"u": np.zeros((4, 1))}, "motion: u: expected 4 samples"),
        ({"a": np.zeros(5)}, "motion: a: expected 4 samples"),
        ({"dt": 0.0}, "motion: dt: expected a time above 0 s, found 0 s"),
    ],
)
def test_a_motion_of_wrong_shape_is_refused(wrong: dict[str, object], words: str) -> None:
    """The kernel reads its rows without looking: it would run over their end."""
    given = {"dt": DT, "x": np.zeros(4), "v": np.zeros(4), "u": np.zeros(4), **wrong}
    with pytest.raises(er_models.InputError, match=words):
        er_models.motion(**given)  # type: ignore[arg-type]


def test_a_duty_of_another_length_than_the_road_is_refused() -> None:
    car = er_models.load_model(CONFIG / "vehicles" / "inove_quarter_car.yaml")
    with pytest.raises(er_models.InputError, match="samples as the road"):
        er_models.simulate(car, DT, np.zeros(5), np.zeros(4))


def test_what_a_model_does_not_say_of_an_optional_value_is_neutral() -> None:
    """Models written before an effect was given the value go on meaning what they meant."""
    stop = {"k_b": 1000.0, "x_b": 0.008}
    made = Model("m", {"end_stop": stop}, SMALL)
    assert made.effects["end_stop"] == {**stop, "k_c": 0.0}
    assert made.with_effect("end_stop", stop) == made
    assert made.with_effect("end_stop").value("end_stop", "k_c") > 0.0
    with pytest.raises(InputError, match=r"end_stop\.x_b: expected a value in m, found nothing"):
        Model("m", {"end_stop": {"k_b": 1000.0}}, SMALL)

"""The parameter table: promotion, bounds, and one clear line for every kind of mistake."""

from __future__ import annotations

import math
from dataclasses import FrozenInstanceError, dataclass
from typing import Any

import pytest
from er_common.parameter_table import REQUIRED, build, param, specs
from er_models.errors import InputError


@dataclass(frozen=True, kw_only=True)
class Table:
    """One parameter of each kind."""

    rate: float = param(200.0, unit="Hz", low=1.0, high=2000.0, text="steps per second")
    model: str = param(REQUIRED, text="model file")
    mode: str = param("real", choices=("real", "lockstep"), text="what drives time")
    seed: int = param(0, low=0, text="seed of the noise")
    noisy: bool = param(True, text="add noise")
    gains: tuple[float, ...] = param((1.0, 2.0), unit="N s/m", length=2, low=0.0, text="gains")
    steps: tuple[int, ...] = param((), text="steps")
    effects: tuple[str, ...] = param((), text="hidden effects", name="plant.effects")


def made(**given: Any) -> Table:
    """Table with a model and the given parameters."""
    return build(Table, {"model": "m.yaml"} | given, dict.fromkeys(given, "p.yaml"))


def test_defaults_and_given_values() -> None:
    values = made(mode="lockstep", **{"plant.effects": ["gas_spring"]})
    assert values.rate == 200.0
    assert values.mode == "lockstep"
    assert values.effects == ("gas_spring",)


def test_integer_becomes_a_number_and_lists_become_tuples() -> None:
    values = made(rate=100, gains=[1, 2.5])
    assert isinstance(values.rate, float)
    assert values.gains == (1.0, 2.5)
    assert all(isinstance(gain, float) for gain in values.gains)


def test_result_is_frozen() -> None:
    with pytest.raises(FrozenInstanceError):
        made().rate = 1.0  # type: ignore[misc]


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("rate", math.nan, "a number in 1..2000 [Hz]"),
        ("rate", math.inf, "a number in 1..2000 [Hz]"),
        ("rate", 0.5, "a number in 1..2000 [Hz]"),
        ("rate", "fast", "a number in 1..2000 [Hz]"),
        ("rate", True, "a number in 1..2000 [Hz]"),
        ("seed", 1.5, "an integer >= 0"),
        ("seed", -1, "an integer >= 0"),
        ("seed", True, "an integer >= 0"),
        ("noisy", 1, "true or false"),
        ("model", 3, "a text"),
        ("mode", "fast", "one of real, lockstep"),
        ("gains", [1.0], "a list of 2 numbers >= 0 [N s/m]"),
        ("gains", [1.0, math.nan], "a list of 2 numbers >= 0 [N s/m]"),
        ("gains", [1.0, -2.0], "a list of 2 numbers >= 0 [N s/m]"),
        ("gains", 1.0, "a list of 2 numbers >= 0 [N s/m]"),
        ("gains", "12", "a list of 2 numbers >= 0 [N s/m]"),
        ("steps", [1.5], "a list of integers"),
    ],
)
def test_bad_value_names_file_key_expected_and_found(
    name: str, value: object, expected: str
) -> None:
    with pytest.raises(InputError) as caught:
        made(**{name: value})
    text = str(caught.value)
    assert text.startswith(f"p.yaml: {name}: expected {expected}, found ")
    assert "\n" not in text


def test_unknown_name_is_refused_with_the_nearest_one() -> None:
    with pytest.raises(InputError, match=r"^p\.yaml: rte: .*did you mean rate\?"):
        made(rte=100.0)


def test_required_parameter_must_be_given() -> None:
    with pytest.raises(InputError, match="model: expected a text: model file, found nothing"):
        build(Table, {}, {})


def test_fields_without_specification_are_a_mistake_of_the_programmer() -> None:
    @dataclass(frozen=True)
    class Plain:
        rate: float = 1.0

    with pytest.raises(TypeError, match="not declared with param"):
        specs(Plain)


def test_unsupported_type_is_a_mistake_of_the_programmer() -> None:
    @dataclass(frozen=True)
    class Odd:
        rate: complex = param(1.0, text="rate")

    with pytest.raises(TypeError, match="is not a parameter type"):
        specs(Odd)

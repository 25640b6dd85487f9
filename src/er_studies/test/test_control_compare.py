"""The comparison: its measures against the standard and by hand, its files, and what it must find."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from er_models.errors import ErError
from er_models.forms.loss import Factors
from er_studies.control import tradeoff
from er_studies.control.closed_loop import known
from er_studies.control.endurance import Ride, ride
from er_studies.control.measures import Measures, outside, w_k, weighted
from er_studies.control.run import Outcome, Setup, compare, judged, run, setup
from er_studies.control.scenarios import load_scenario, load_scenarios
from er_studies.control.table import markdown, means, paired

CONFIG = Path(__file__).resolve().parents[3] / "config"
FOLDER = CONFIG / "scenarios" / "control"


@pytest.fixture(scope="module")
def of() -> Setup:
    return setup(CONFIG)


@pytest.mark.parametrize(
    ("hertz", "weight"),
    [(0.5, 0.418), (1.0, 0.482), (2.0, 0.531), (4.0, 0.967), (6.3, 1.054), (8.0, 1.036), (16.0, 0.768), (31.5, 0.405)],
)  # fmt: skip
def test_comfort_is_weighted_as_the_standard_s_table_says(hertz: float, weight: float) -> None:
    assert float(w_k(np.array([hertz]))[0]) == pytest.approx(weight, rel=0.01)
    t = 0.005 * np.arange(20_000)
    felt = weighted(np.sin(2.0 * np.pi * hertz * t), 0.005)
    assert float(np.sqrt(2.0 * np.mean(felt**2))) == pytest.approx(weight, rel=0.012)


def test_a_force_outside_the_true_domain_is_a_violation(of: Setup) -> None:
    from er_models.static_damper import static_damper

    damper, x, v = static_damper(of.model), np.full(4, 0.001), np.full(4, 0.1)
    healthy, faulty = Factors(), Factors(leakage=0.5)
    top = float(damper.domain(x, v, (0.0, 1.0), faulty).high[0])
    record = {
        "t": np.arange(4.0), "meant_deflection": x, "meant_velocity": v,
        "left": np.array([[1.0, 1.0, 1.0], [1.0, 0.5, 1.0], [1.0, 0.5, 1.0], [1.0, 0.5, 1.0]]),
        "given": np.array([top + 1.0, top + 1.0, top + 0.1, top]),
        "wanted": np.array([top, top, top, top + 2.0]),
    }  # fmt: skip
    assert top + 1.0 < float(damper.domain(x, v, (0.0, 1.0), healthy).high[0])
    found = outside(record, "given", damper, (0.0, 1.0), 0.5)
    assert found.tolist() == [False, True, False, False]
    asked = outside(record, "wanted", damper, (0.0, 1.0), 0.5)
    assert asked.tolist() == [False, False, False, True]


def test_differences_are_paired_by_road() -> None:
    def row(law: str, k: int, rms: float) -> Outcome:
        return Outcome("s", "f", law, k, Measures(rms, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0))

    rows = [row("a", k, 1.0 + k + 0.1) for k in range(4)] + [
        row("b", k, 1.0 + k) for k in range(4)
    ]
    found = paired(rows, "rms", "a", "b")
    assert found.mean == pytest.approx(0.1 / 2.5)
    assert found.half == pytest.approx(0.0, abs=1e-12)
    assert math.isnan(paired([rows[0], rows[4]], "rms", "a", "b").half)


def test_the_interval_of_a_difference_is_students_at_95_per_cent() -> None:
    """Differences 0.1, 0.2, 0.3 and 0.4: the standard error is 0.0645, and t of three degrees of freedom 3.182."""

    def row(law: str, k: int, rms: float) -> Outcome:
        return Outcome("s", "f", law, k, Measures(rms, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0))

    rows = [row("a", k, 1.1 + 0.1 * k) for k in range(4)] + [row("b", k, 1.0) for k in range(4)]
    found = paired(rows, "rms", "a", "b")
    assert found.mean == pytest.approx(0.25)
    assert found.half == pytest.approx(3.182 * 0.06455, rel=1e-3)


def test_with_a_leak_it_lowers_the_deflection_and_respects_the_domain(of: Setup) -> None:
    """The heart of chapter 6 on a few roads; all of them are in docs/results/control_comparison.md."""
    (whole,) = load_scenarios(FOLDER, ["thesis_6_4_2"])
    s = replace(whole, faults={"leakage": whole.faults["leakage"]})
    rows = compare(of, [s], known, 3, laws=("passive", "nominal", "fault_tolerant"))
    gap = paired(rows, "rms", "fault_tolerant", "nominal")
    assert gap.mean + gap.half < 0.0
    ours, passive = means(rows, "fault_tolerant"), means(rows, "passive")
    assert ours.violations == ours.safe == 0.0
    # a state feedback asks for forces of both signs: what no damper gives is clipped
    assert 0.0 < ours.wishes < 0.5
    assert ours.rms < 0.90 * passive.rms
    assert ours.tyre < passive.tyre
    assert ours.comfort < 1.03 * passive.comfort
    text = markdown([s], rows, "known")
    assert "| leakage | fault_tolerant |" in text
    assert f"{1e3 * ours.rms:.3f}" in text


def test_a_dead_zone_gives_deflection_for_comfort_and_an_electrical_fault_costs_none(
    of: Setup,
) -> None:
    (s,) = load_scenarios(FOLDER, ["thesis_6_4_2"])
    changes = [{"horizon": 0.02, "dead_zone": zone} for zone in (0.0, of.parameters.dead_zone)]
    changes.append({"horizon": 0.02, "dead_zone": of.parameters.dead_zone, "mu": math.inf})
    bold, shipped, frozen = tradeoff.points(of, s, ("electrical",), 1, changes)
    assert bold.deflection["electrical"] < shipped.deflection["electrical"] < 0.0
    assert bold.comfort["electrical"] > 0.01
    assert abs(shipped.comfort["electrical"]) < 0.01
    assert (
        shipped.moved["electrical"] > 0.0 == frozen.moved["electrical"]
    )  # an infinite mu keeps rho where it is
    assert tradeoff.markdown([bold, shipped]).count("\n") == 3


def test_a_ride_says_how_far_it_has_come(of: Setup) -> None:
    told: list[tuple[int, int]] = []
    r = Ride(4.0)
    found = ride(of, known, r, lambda done, total: told.append((done, total)))
    assert told == [(second, 8) for second in (*range(5), *range(4, 9))]
    assert found == ride(of, known, r)


def test_a_run_repeats_bit_for_bit_and_another_road_does_not(of: Setup) -> None:
    (whole,) = load_scenarios(FOLDER, ["thesis_6_4_1"])
    program = replace(whole.program, duration=4.0)
    s = replace(whole, program=program, window=(2.5, 4.0))
    law = of.law("fault_tolerant", s)
    one, two, other = (run(of, s, "combined", law, known, k) for k in (0, 0, 1))
    assert all(np.array_equal(one[name], two[name], equal_nan=True) for name in one)
    assert not np.array_equal(one["duty"], other["duty"])
    assert one["left"][-1].tolist() == [0.7, 0.8, 0.8]
    assert np.allclose(one["believed"][-1], [0.7, 0.8, 0.8])
    assert judged(of, s, one).violations == 0.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"schema": "er_scenario 1"}, "schema: expected"),
        ({"duty_max": 2.0}, "duty_max: expected"),
        ({"window": {"begin": 5.0, "end": 50.0}}, "window: expected begin < end"),
        ({"faults": {}}, "faults: expected"),
        ({"faults": {"x": {"oil_leak": {"f": 0.5}}}}, "did you mean"),
        ({"faults": {"x": {"oil_leakage": {"f": 1.5}}}}, "f: expected 0 to 1"),
        ({"latncy": 1}, "latncy"),
    ],
)
def test_a_wrong_file_is_one_line_that_names_the_key(
    tmp_path: Path, change: dict[str, object], words: str
) -> None:
    document = yaml.safe_load((FOLDER / "thesis_6_4_2.yaml").read_text())
    file = tmp_path / "wrong.yaml"
    file.write_text(yaml.safe_dump(document | change))
    with pytest.raises(ErError, match=words) as caught:
        load_scenario(file)
    assert "\n" not in str(caught.value)

"""The benchmark says what its runs were worth: ratios, aims, losses, and a machine that is too busy."""

from __future__ import annotations

from dataclasses import replace

import pytest

pytest.importorskip("rclpy")

from er_studies.bench.graph import Load
from er_studies.bench.ros import Result, failed, markdown, specs

GOOD = Result(
    "composed", "events", (0.3, 0.8, 2.0, 4.0), (0.1, 0.3, 0.5, 1.0), 0, 12000,
    (Load("composed", 11.0, 230.0),), 2.0, 0.2,
)  # fmt: skip
PLAIN = replace(
    GOOD, executor="single", loop=(1.5, 6.0, 9.0, 12.0), loads=(Load("composed", 44.0, 230.0),)
)


def test_ratios_stand_beside_one_another() -> None:
    text = markdown([GOOD, PLAIN], 60.0, 200.0)
    assert "- composed: plain rclpy uses 4.0 times the CPU, loop p50 5.0 times as long" in text
    assert "p50 0.30 of 0.4 ms, p99 0.80 of 1 ms" in text
    assert "too noisy" not in text
    assert "too noisy to judge latencies: others used 40 %" in markdown(
        [replace(GOOD, others=40.0)], 60.0, 200.0
    )


@pytest.mark.parametrize(
    ("result", "bad"),
    [
        (GOOD, False),
        (replace(GOOD, lost=1), True),
        (replace(GOOD, loop=(0.3, 1.1, 2.0, 4.0)), True),
        (replace(GOOD, loads=(Load("composed", 13.0, 230.0),)), True),
        (replace(GOOD, loop=(0.3, 9.0, 9.0, 9.0), others=50.0), False),
        (replace(PLAIN, lost=50), False),
    ],
)
def test_an_aim_that_is_missed_on_a_quiet_machine_is_a_failure(result: Result, bad: bool) -> None:
    assert failed([result], 200.0) is bad


@pytest.mark.parametrize("layout", ["processes", "composed"])
@pytest.mark.parametrize(("controller", "told"), [("skyhook", 2), ("ftc", 3)])
def test_every_node_gets_the_executor_and_who_is_made_for_one_the_rate(
    layout: str, controller: str, told: int
) -> None:
    found = specs(layout, "single", 5.0, 400.0, controller)
    words = [" ".join(spec.arguments()) for spec in found]
    assert sum(each.count("executor:='single'") for each in words) == 6
    assert sum(each.count("rate:=400.0") for each in words) == told

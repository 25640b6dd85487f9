"""Parameters of the plant node: which there are, and the rig they make."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from er_common.parameter_table import build as checked
from er_models.errors import InputError
from er_models.program import load_program
from er_models.simulation import substeps
from er_plant_sim.build import build, load_given_program, with_planned
from er_plant_sim.duty_gate import Command, Reason
from er_plant_sim.rig import (
    Rig,
    RigState,
    advance,
    decide,
    finished,
    receive,
    road,
    sense,
    start,
    time,
)
from er_plant_sim.settings import table

CONFIG = Path(__file__).parents[3] / "config"
BASE = {"model_file": str(CONFIG / "vehicles/inove_quarter_car.yaml"), "safe_duty": 0.1}
IDENTIFICATION = str(CONFIG / "experiments/identification.yaml")
CHIRP = str(CONFIG / "experiments/chirp.yaml")


def parameters(**given: Any) -> Any:
    """Parameters as the node would get them; a double underscore stands for a dot."""
    named = {key.replace("__", "."): value for key, value in given.items()}
    return checked(table(named), BASE | named, {})


def rig(**given: Any) -> Rig:
    """The rig of these parameters."""
    return build(parameters(**given))


def test_the_program_file_is_taken_as_it_is() -> None:
    assert load_given_program(parameters(program_file=CHIRP)).road == load_program(CHIRP).road


def test_single_settings_go_over_the_file() -> None:
    program = load_given_program(parameters(program_file=CHIRP, road__f1=5.0, duty__level=0.1))
    assert program.road["f1"] == 5.0
    assert program.road["amplitude"] == load_program(CHIRP).road["amplitude"]
    assert program.duty["level"] == 0.1


def test_another_kind_keeps_nothing_of_the_file() -> None:
    program = load_given_program(
        parameters(program_file=CHIRP, road__kind="step", road__height=0.01)
    )
    assert dict(program.road) == {"kind": "step", "height": 0.01}


def test_duration_and_seed_are_the_programs_unless_given() -> None:
    program = load_given_program(parameters(program_file=CHIRP))
    assert (program.duration, program.seed) == (20.0, 0)
    program = load_given_program(parameters(program_file=CHIRP, duration=3.0, seed=9))
    assert (program.duration, program.seed) == (3.0, 9)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "program_file: expected a program file, or road.kind"),
        ({"road__kind": "sine"}, "road.amplitude"),
        ({"road__kind": "sine", "road__height": 1.0}, "road.height: expected one of"),
        ({"program_file": CHIRP, "rate_factor": 0.0}, "rate_factor: expected above 0"),
        ({"program_file": CHIRP, "rate_factor": 3.0}, "rate_factor: expected 1 in mode realtime"),
        ({"program_file": CHIRP, "safe_duty": 0.5}, "safe_duty"),
    ],
)
def test_what_does_not_fit_is_named(given: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        rig(**given)


def test_a_setting_that_no_road_has_is_unknown() -> None:
    with pytest.raises(
        InputError, match=r"road.ampltude: expected .* .did you mean road.amplitude"
    ):
        parameters(program_file=CHIRP, road__ampltude=0.1)


SEQUENCE = """
schema: er_program 1
duration: 4.0
moves: {moves}
road: {{kind: sequence, parts: [{{kind: sine, seconds: 1.0, amplitude: 0.002, frequency: 3.0}}]}}
duty: {{kind: sequence, parts: [{{kind: constant, seconds: 0.5, level: 0.2}}, {{kind: square, seconds: 1.0}}]}}
"""


def test_a_program_of_several_parts_runs_and_one_for_a_machine_does_not(tmp_path: Path) -> None:
    path = tmp_path / "parts.yaml"
    path.write_text(SEQUENCE.format(moves="wheel"))
    made = rig(program_file=str(path))
    expected = load_program(path).signals(0.005 * np.arange(300))[0]
    assert [road(made, k) for k in range(300)] == pytest.approx(expected, abs=1e-15)
    path.write_text(SEQUENCE.format(moves="damper"))
    assert load_given_program(parameters(program_file=str(path))).moves == "damper"
    with pytest.raises(InputError, match=r"parts.yaml: moves: expected wheel .* found damper"):
        rig(program_file=str(path))


def test_the_limits_of_the_duty_come_from_the_model() -> None:
    made = rig(program_file=CHIRP, duty__level=0.9)
    assert made.gate.duty_max == 0.3
    _, applied = decide(made, start(made))
    assert (applied.duty, applied.saturated) == (0.3, True)


def test_a_road_that_was_scaled_is_known_beforehand() -> None:
    path = str(CONFIG / "experiments/identification.yaml")
    made = rig(program_file=path, duration=2.0, rate=1000.0)
    later = replace(made, known=np.empty(0))
    assert made.known.size == 2000 * substeps(made.dt) + 1
    expected = [road(later, k) for k in range(2100)]
    assert max(map(abs, expected)) > 1e-3
    # but for the order in which sums of many rows are taken
    assert [road(made, k) for k in range(2100)] == pytest.approx(expected, abs=1e-15)


def test_a_peak_velocity_means_the_known_vehicle_not_what_is_hidden_in_it() -> None:
    program = str(CONFIG / "experiments/iso_steps.yaml")
    bingham = str(CONFIG / "dampers/inove_bingham.yaml")
    known, other = rig(program_file=program), rig(program_file=program, damper_file=bingham)
    assert [road(known, k) for k in range(400)] == [road(other, k) for k in range(400)]
    assert "bingham_yield" in other.sim.plant.model.effects


def test_a_damper_of_another_size_is_refused_with_its_numbers() -> None:
    monotube = str(CONFIG / "dampers/monotube_passive.yaml")
    with pytest.raises(InputError, match=r"1500 N on a body of 2.27 kg: static deflection 75"):
        rig(program_file=CHIRP, damper_file=monotube)
    car = str(CONFIG / "vehicles/small_car.yaml")
    assert rig(program_file=CHIRP, model_file=car, damper_file=monotube).dt == 0.005


def test_a_planned_run_says_the_duty_within_the_rig_and_commands_do_before_and_after(
    tmp_path: Path,
) -> None:
    path = tmp_path / "run.yaml"
    path.write_text(
        "schema: er_program 1\nduration: 0.5\nduty: {kind: constant, level: 0.25}\n"
        "road: {kind: sine, amplitude: 0.002, frequency: 2.0}\n"
    )
    p = parameters(program_file=IDENTIFICATION, duty_source="topic", planned_file=str(path))
    plain = build(replace(p, planned_file=""))
    made, said = with_planned(p, plain, 300), []
    state = start(plain)
    for k in range(1, 800):
        rig_now = plain if k < 300 else made
        command = Command(time(rig_now, state), k, 0.05, 2)
        state = receive(rig_now, state, command, valid=True)
        state, applied = decide(rig_now, state)
        said.append((applied.reason, round(applied.duty, 3)))
        state = advance(rig_now, state)
    ruled = slice(499, 599)  # one second later, for half a second
    assert set(said[ruled]) == {(Reason.PROGRAM, 0.25)}
    assert {*said[:499], *said[599:]} == {(Reason.COMMAND, 0.05)}
    heights = np.array([[road(r, k) for k in range(900)] for r in (plain, made)])
    assert np.array_equal(*heights[:, :300])
    assert np.allclose(*heights[:, 801:], rtol=0.0, atol=1e-15)  # as where a road is known
    assert heights[1, 525] == pytest.approx(0.002, abs=1e-6)
    back = with_planned(replace(p, planned_file=""), made, 520)
    assert [decide(back, s)[1].reason for s in (jumped(state, 519), jumped(state, 520))] == [
        Reason.PROGRAM,
        Reason.COMMAND,
    ]
    assert build(p).program != plain.program, "given from the beginning it is driven first"


def jumped(state: RigState, tick: int) -> RigState:
    """The state with a fresh command, at another tick."""
    gate = state.gate._replace(command=Command(0.005 * tick, tick, 0.05, 2))
    return RigState(state.sim._replace(tick=tick), gate)


def test_the_rig_ends_with_the_program() -> None:
    made = rig(program_file=CHIRP, duration=0.05)
    state, ticks = start(made), []
    while not finished(made, state):
        ticks.append(sense(made, state).tick)
        state = advance(made, decide(made, state)[0])
    assert ticks == list(range(1, 11))


def test_without_end_it_never_ends() -> None:
    made = rig(program_file=CHIRP, duration=0.0)
    state = start(made)
    for _ in range(3):
        state = advance(made, state)
    assert not finished(made, state)


def test_commands_count_only_where_they_are_asked_for() -> None:
    for source, reason in (("topic", Reason.COMMAND), ("program", Reason.PROGRAM)):
        made = rig(program_file=CHIRP, duty_source=source)
        state = start(made)
        state = receive(made, state, Command(time(made, state), 1, 0.2, 2), valid=True)
        assert decide(made, state)[1].reason is reason


def test_the_seed_makes_road_and_noise() -> None:
    program = str(CONFIG / "experiments/iso_steps.yaml")
    same = [rig(program_file=program, seed=s, noise__force=0.1) for s in (4, 4, 5)]
    heights = [[road(made, k) for k in range(50)] for made in same]
    forces = [sense(made, start(made)).force for made in same]
    assert heights[0] == heights[1] != heights[2]
    assert forces[0] == forces[1] != forces[2]

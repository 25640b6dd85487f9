"""Units for co-simulation, validated and run by FMPy, against the kernel."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from c_help import needs_compiler
from er_models.export import fmu
from er_models.export.fmu import write_fmu
from er_models.files import load_model
from er_models.model import Array, Model
from er_models.prediction import Motion, predict
from models_help import DT, SMALL, guo, imposed, span

fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed: pip install fmpy")
CLOSE = 1e-9
NAMES = ("deflection", "velocity", "acceleration", "duty")


def late() -> Model:
    """A damper with states, a dead time and a force that lags."""
    model = guo().with_effect("dead_time", {"T_d": 0.0071}).with_effect("force_lag")
    return replace(model.with_effect("bouc_wen_hysteresis"), name="late damper")


MODELS = {"inove_guo": guo(), "utfsm_mr": load_model("utfsm_mr"), "late damper": late()}


@pytest.fixture(scope="module")
def units(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, int], Path]:
    """A unit of every model and version."""
    folder, made = tmp_path_factory.mktemp("fmu"), {}
    for name, model in MODELS.items():
        for version in fmu.VERSIONS:
            made[name, version] = folder / f"{name}{version}.fmu"
            assert write_fmu(model, made[name, version], version)
    return made


CASES = pytest.mark.parametrize(
    ("name", "version"), [(n, v) for n in MODELS for v in fmu.VERSIONS]
)


def instance(path: Path, tmp_path: Path) -> tuple[Any, Any, dict[str, int]]:
    """A unit that is instantiated, with its description and references."""
    about = fmpy.read_model_description(str(path))
    kind = fmpy.fmi3.FMU3Slave if about.fmiVersion == "3.0" else fmpy.fmi2.FMU2Slave
    made = kind(
        guid=about.guid, unzipDirectory=fmpy.extract(str(path), str(tmp_path / "unit")),
        modelIdentifier=about.coSimulation.modelIdentifier, instanceName="one",
    )  # fmt: skip
    made.instantiate()
    return made, about, {v.name: v.valueReference for v in about.modelVariables}


def access(made: Any) -> tuple[Any, Any]:
    """How numbers are set and read, whichever version."""
    three = hasattr(made, "setFloat64")
    return (made.setFloat64, made.getFloat64) if three else (made.setReal, made.getReal)


def begin(made: Any) -> None:
    """Through the initialization at time zero."""
    if hasattr(made, "setupExperiment"):
        made.setupExperiment(startTime=0.0)
    made.enterInitializationMode()


def stepped(path: Path, inputs: Motion, tmp_path: Path) -> Array:
    """Force (n,) [N] at communication points: the inputs of the end of each step are set before it."""
    made, _, vr = instance(path, tmp_path)
    write, read = access(made)
    rows = np.column_stack([inputs.x, inputs.v, inputs.a, inputs.u]).tolist()
    places = [vr[n] for n in NAMES]
    begin(made)
    write(places, rows[0])
    made.exitInitializationMode()
    force = [read([vr["force"]])[0]]
    for k, row in enumerate(rows[1:]):
        write(places, row)
        made.doStep(currentCommunicationPoint=k * inputs.dt, communicationStepSize=inputs.dt)
        force.append(read([vr["force"]])[0])
    made.terminate()
    made.freeInstance()
    return np.array(force)


@needs_compiler
@CASES
def test_fmpy_finds_nothing_wrong(
    name: str, version: int, units: dict[tuple[str, int], Path]
) -> None:
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(units[name, version])) == []


@needs_compiler
@CASES
def test_the_force_is_that_of_the_kernel(
    name: str, version: int, units: dict[tuple[str, int], Path], tmp_path: Path
) -> None:
    inputs = imposed(MODELS[name].scales, 1.0)
    expected = predict(MODELS[name], inputs)
    assert np.abs(stepped(units[name, version], inputs, tmp_path) - expected).max() < CLOSE * span(
        expected
    )


def simulated(path: Path, inputs: Motion, **more: Any) -> Array:
    """Force (n,) [N] as FMPy runs a unit: inputs of the beginning of each step."""
    t = np.arange(inputs.n) * inputs.dt
    rows = list(zip(t, inputs.x, inputs.v, inputs.a, inputs.u, strict=True))
    signals = np.array(rows, dtype=[("time", float), *((n, float) for n in NAMES)])
    found = fmpy.simulate_fmu(
        str(path),
        stop_time=t[-1],
        output_interval=inputs.dt,
        input=signals,
        output=["force"],
        **more,
    )
    return np.asarray(found["force"])


@needs_compiler
def test_with_derivatives_fmi_2_takes_the_inputs_of_the_beginning(
    units: dict[tuple[str, int], Path], tmp_path: Path
) -> None:
    inputs = imposed(SMALL, 0.5)
    expected = predict(guo(), inputs)
    made, _, vr = instance(units["inove_guo", 2], tmp_path)
    rows = np.column_stack([inputs.x, inputs.v, inputs.a, inputs.u])
    places, force = [vr[n] for n in NAMES], []
    begin(made)
    made.setReal(places, rows[0].tolist())
    made.exitInitializationMode()
    for k, (row, rise) in enumerate(zip(rows, np.diff(rows, axis=0), strict=False)):
        made.setReal(places, row.tolist())
        made.setRealInputDerivatives(places, [1] * len(places), (rise / DT).tolist())
        made.doStep(currentCommunicationPoint=k * DT, communicationStepSize=DT)
        force.append(made.getReal([vr["force"]])[0])
    assert np.abs(np.array(force) - expected[1:]).max() < CLOSE * span(expected)


@needs_compiler
@pytest.mark.parametrize("version", fmu.VERSIONS)
def test_inputs_at_the_start_carry_the_motion_on(
    version: int, units: dict[tuple[str, int], Path]
) -> None:
    """Without them the force comes one step late."""
    inputs = imposed(SMALL, 1.0, 1e-3)
    expected = predict(guo(), inputs)
    jumped = np.append(np.flatnonzero(np.diff(inputs.u)) + 1, 0)
    same = np.setdiff1d(np.arange(inputs.n), jumped)
    path = units["inove_guo", version]
    on = simulated(path, inputs, start_values={"inputs_at_start": True})
    as_it_is = simulated(path, inputs)
    error = [np.abs(f - expected)[same].max() / span(expected) for f in (on, as_it_is)]
    assert error[0] < 5e-4
    assert error[1] > 10 * error[0]


@needs_compiler
@pytest.mark.parametrize("version", fmu.VERSIONS)
def test_a_step_can_be_taken_back_and_parameters_changed(
    version: int, units: dict[tuple[str, int], Path], tmp_path: Path
) -> None:
    made, about, vr = instance(units["late damper", version], tmp_path)
    write, read = access(made)
    places = [vr[n] for n in NAMES]
    write([vr["passive.k0"]], [500.0])
    begin(made)
    write(places, [0.004, 0.0, 0.0, 0.0])
    assert read([vr["force"]])[0] == pytest.approx(2.0)
    made.exitInitializationMode()
    get, back = (
        getattr(made, f"{w}FMUState", None) or getattr(made, f"{w}FMUstate")
        for w in ("get", "set")
    )
    state = get()
    runs = []
    for _ in range(2):
        write(places, [0.005, 0.05, 1.0, 0.2])
        made.doStep(currentCommunicationPoint=0.0, communicationStepSize=DT)
        runs.append(read([vr["force"], vr["true_force"], vr["passive.k0"]]))
        back(state)
    assert runs[0] == runs[1]
    assert runs[0][0] != runs[0][1]
    write([vr["passive.k0"]], [0.0])
    assert about.coSimulation.canHandleVariableCommunicationStepSize


@needs_compiler
@CASES
def test_parameters_have_values_units_and_bounds(
    name: str, version: int, units: dict[tuple[str, int], Path]
) -> None:
    model = MODELS[name]
    about = fmpy.read_model_description(str(units[name, version]))
    known = {
        v.name: v
        for v in about.modelVariables
        if v.causality == "parameter" and v.type != "Boolean"
    }
    assert set(known) == {f"{e}.{q}" for e, own in model.effects.items() for q in own}
    for effect, own in model.effects.items():
        for parameter, value in own.items():
            v, low_high = known[f"{effect}.{parameter}"], model.bounds(effect, parameter)
            assert float(v.start) == value
            assert v.unit == model.catalogue[effect].parameter(parameter).unit
            assert (float(v.min), float(v.max)) == (
                min(low_high[0], value),
                max(low_high[1], value),
            )
    units_known = {u.name for u in about.unitDefinitions}
    assert {v.unit for v in known.values()} <= units_known
    inputs = {v.name: v.unit for v in about.modelVariables if v.causality == "input"}
    assert inputs == dict(zip(NAMES, ("m", "m/s", "m/s2", "1"), strict=True))

"""A solver that gets stuck is asked again with other settings, and refusals are believed from two."""

import os
import signal
import subprocess
import sys

import cvxpy as cp
import numpy as np
import pytest
from er_observers.running.ready import ready
from er_observers.synthesis import solver
from er_observers.synthesis.solver import ATTEMPTS, SOLVER, run


def least_trace(least=1.0):
    """The symmetric matrix above `least` with the smallest trace."""
    P = cp.Variable((2, 2), symmetric=True)
    return P, cp.Problem(cp.Minimize(cp.trace(P)), [P >> least * np.eye(2)])


@pytest.fixture
def asked(monkeypatch):
    """Settings asked for so far, and answers that stand for the solver's as long as there are any."""
    options, answers = [], []
    really = solver._once

    def once(problem, name, settings):
        options.append(settings)
        return answers.pop(0) if answers else really(problem, name, settings)

    monkeypatch.setattr(solver, "_once", once)
    return options, answers


def test_the_first_answer_is_enough(asked):
    P, problem = least_trace()
    assert run(problem) == "optimal"
    np.testing.assert_allclose(P.value, np.eye(2), atol=1e-6)
    assert asked[0] == [ATTEMPTS[SOLVER][0]]


def test_a_failure_is_asked_again_with_other_settings(asked):
    options, answers = asked
    answers += ["failed: stuck", "infeasible"]
    P, problem = least_trace()
    assert run(problem) == "optimal"
    np.testing.assert_allclose(P.value, np.eye(2), atol=1e-6)
    assert options == list(ATTEMPTS[SOLVER][:3])


def test_a_refusal_is_believed_from_two_settings(asked):
    options, answers = asked
    answers += ["infeasible", "infeasible_inaccurate", "optimal"]
    assert run(least_trace()[1]) == "infeasible"
    assert len(options) == solver.SURE


def test_what_cannot_be_used_is_not_taken(asked):
    P, problem = least_trace()
    assert run(problem, usable=lambda: P.value[0, 0] > 2.0) == "optimal"
    assert asked[0] == list(ATTEMPTS[SOLVER])


@pytest.mark.parametrize("settings", ATTEMPTS[SOLVER])
def test_every_setting_is_known_to_the_solver(settings):
    P, problem = least_trace(3.0)
    assert solver._once(problem, SOLVER, settings) == "optimal"
    np.testing.assert_allclose(P.value, 3.0 * np.eye(2), atol=1e-5)


@pytest.mark.parametrize("kernels", ["Haswell", "SkylakeX", "Nehalem"])
def test_other_processors_find_the_same_observer(kernels, car, car_file, gains, tmp_path):
    """The linear algebra of other processors, as OpenBLAS lets us choose it: what is promised is the same."""
    out = tmp_path / "gains.yaml"
    command = [
        sys.executable,
        "-m",
        "er_observers.synth",
        "nlpv_polytopic",
        "--model",
        car_file,
        "--out",
        out,
    ]
    chosen = {**os.environ, "OPENBLAS_CORETYPE": kernels}
    done = subprocess.run(command, env=chosen, capture_output=True, text=True, check=False)
    if done.returncode == -signal.SIGILL:
        pytest.skip(f"this processor has no instructions of {kernels}")
    assert done.returncode == 0, done.stderr
    found = ready(out, car, "nlpv_polytopic")
    assert found.claim.solution.gamma == pytest.approx(gains.claim.solution.gamma, rel=1e-3)
    assert found.watch.pace == pytest.approx(gains.watch.pace, rel=0.02)

"""Filter and smoother against the posterior of all samples at once, from dense matrices, which ask for mild numbers."""

import numpy as np
import pytest
from er_model_lab.motion.chain import LAGGING, STATES, diffusion, filtered, smoothed, transition

DT, N = 0.1, 25
VARIANCES = np.array([0.02, 0.1, 0.3]) ** 2
SETTLED = 8


def case(order, lag, seed=3):
    """Arguments of the filter: motion model, rows of the channels, activity and spread of the first state."""
    m = LAGGING if lag > 0 else STATES
    rows = np.zeros((3, m))
    rows[0, 0] = rows[2, 2] = rows[2, 4] = 1.0
    rows[1, 5 if lag > 0 else 1] = 1.0
    rng = np.random.default_rng(seed)
    spread = np.array([0.5, 0.4, 2.0, 3.0 if order == 4 else 0.0, 0.2, 0.4][:m]) ** 2
    return m, rows, rng.uniform(0.2, 3.0, N), spread, rng.standard_normal((N, 3))


def posterior(order, lag, has, drive, samples=N):
    """Mean (n, m), covariances (n, m, m) and log density of what was measured, constants left out."""
    m, rows, activity, spread, zs = case(order, lag)
    f, d = transition(DT, order, lag, m), diffusion(DT, order, lag, m)
    prior = np.zeros((N * m, N * m))
    blocks = [np.diag(spread)]
    for k in range(1, N):
        blocks.append(f @ blocks[-1] @ f.T + drive * activity[k] * d)
    for k in range(N):
        step = np.eye(m)
        for j in range(k, N):
            prior[j * m : (j + 1) * m, k * m : (k + 1) * m] = step @ blocks[k]
            prior[k * m : (k + 1) * m, j * m : (j + 1) * m] = (step @ blocks[k]).T
            step = f @ step
    use = [(k, c) for k in range(samples) for c in range(3) if has[c]]
    h = np.zeros((len(use), N * m))
    for i, (k, c) in enumerate(use):
        h[i, k * m : (k + 1) * m] = rows[c]
    y = np.array([zs[k, c] for k, c in use])
    s = h @ prior @ h.T + np.diag([VARIANCES[c] for _, c in use])
    gain = np.linalg.solve(s, h @ prior).T
    spread_all = prior - gain @ h @ prior
    density = -0.5 * (np.linalg.slogdet(s)[1] + y @ np.linalg.solve(s, y))
    at = [slice(k * m, (k + 1) * m) for k in range(N)]
    return (gain @ y).reshape(N, m), np.array([spread_all[a, a] for a in at]), density


@pytest.mark.parametrize("has", [(1, 1, 1), (1, 0, 0), (0, 1, 1), (1, 1, 0)])
@pytest.mark.parametrize(("order", "lag"), [(4, 0.0), (3, 0.0), (4, 0.08), (3, 0.08)])
def test_filter_and_smoother_are_the_posterior(order, lag, has):
    drive = 20.0
    m, rows, activity, spread, zs = case(order, lag)
    xs, xp, ps, pp = (np.empty((N, *(m,) * k)) for k in (1, 1, 2, 2))
    first = tuple(spread.tolist())
    given = (
        DT,
        order,
        lag,
        zs,
        np.tile(np.array(has, np.uint8), (N, 1)),
        rows,
        VARIANCES,
        drive,
        activity,
        first,
    )
    likelihood = filtered(*given, xs, ps, xp, pp)
    smoothed(DT, order, lag, first, xs, ps, xp, pp)
    mean, covariance, density = posterior(order, lag, has, drive)
    scale = np.sqrt(covariance.diagonal(axis1=1, axis2=2)) + 1e-12
    assert np.max(np.abs(xs - mean) / scale) < 1e-6
    assert np.max(np.abs(ps - covariance) / (scale[:, :, None] * scale[:, None, :])) < 1e-6
    begin = posterior(order, lag, has, drive, SETTLED)[2]
    assert likelihood == pytest.approx(density - begin, rel=1e-9)
    nothing = (np.empty((0, *(m,) * k)) for k in (1, 2, 1, 2))
    assert filtered(*given, *nothing) == likelihood

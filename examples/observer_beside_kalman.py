# %% [markdown]
# # An observer in a loop, beside a Kalman filter
#
# Two accelerometers and the duty: what is the damper force? The unified observer answers with proved gains, an extended
# Kalman filter with the same model and noise. Both are pure steps: state and sample in, state and estimate out.

# %%
from pathlib import Path

import numpy as np
from er_models import load_model
from er_models.road import road_profile
from er_models.simulation import simulate
from er_studies.observers import kalman

import er_observers as observers

root = Path(__file__).resolve().parents[1] if "__file__" in globals() else Path()
car = load_model(root / "config" / "vehicles" / "inove_quarter_car.yaml")

# %% [markdown]
# Twenty seconds on a random road, steps of the duty, noisy accelerometers.

# %%
rng, dt, n = np.random.default_rng(4), 0.005, 4000
t = np.arange(n) * dt
road = road_profile(
    {"kind": "iso8608", "road_class": "A", "speed": 10.0, "factor": 0.2}, t, seed=4
)
duty = np.repeat(rng.choice([0.0, 0.1, 0.2, 0.3], n // 200 + 1), 200)[:n]
run = simulate(car, dt, road, duty)
sprung, unsprung = (
    run[name] + 0.025 * rng.standard_normal(n)
    for name in ("sprung_acceleration", "unsprung_acceleration")
)
samples = [observers.Sample(*row) for row in zip(t, sprung, unsprung, duty, strict=True)]

# %% [markdown]
# The gains are read with their certificate, which is proved again. Then the loop: nothing in it raises.

# %%
gains = observers.ready(root / "config" / "gains" / "unified.yaml", car)
ekf = kalman.make("ekf", car)


def followed(start, step, parameters):
    """The force that an estimator follows (n,) [N]."""
    state, force = start(parameters, samples[0]), [0.0]
    for sample in samples[1:]:
        state, estimate = step(parameters, state, sample)
        force.append(estimate.force)
    return np.array(force)


def error(force):
    """Root mean square error after the first two seconds, over the range of the force [1]."""
    true = run["damper_force"][t > 2.0]
    return float(np.sqrt(np.mean((force[t > 2.0] - true) ** 2)) / np.ptp(true))


unified = error(followed(observers.start, observers.step, gains))
filtered = error(followed(kalman.start, kalman.step, ekf))
print(
    f"unified observer {unified:.2%}, extended Kalman filter {filtered:.2%} of the range of the force"
)
assert max(unified, filtered) < 0.05

# %% [markdown]
# # An effect of your own
#
# The load cell shows a force that follows the duty. No effect of the catalogue does that. One small file describes it;
# from then on the lab fits it, judges it and simulates it like any other.

# %%
from pathlib import Path

import numpy as np
from er_models import motion, predict

import er_model_lab as lab

here = Path(__file__).parent if "__file__" in globals() else Path("examples")
file = here / "effects" / "crosstalk.py"
print(file.read_text())

# %%
model = lab.load_model("inove_guo", effects_from=[file])
truth = model.with_effect("voltage_crosstalk", {"K": 4.0})

rng = np.random.default_rng(2)
dt, n = 0.005, 4000
t = np.arange(n) * dt
w = 2 * np.pi * np.array([0.7, 1.3, 2.1, 3.4, 5.2, 7.3])
phase = np.outer(t, w) + rng.uniform(0, 2 * np.pi, w.size)
x, v, a = (
    np.sin(phase) @ (0.036 / w),
    np.cos(phase).sum(axis=1) * 0.036,
    -np.sin(phase) @ (0.036 * w),
)
duty = np.repeat(rng.choice([0.0, 0.1, 0.2, 0.3], n // 150 + 1), 150)[:n]
force = predict(truth, motion(dt, x, v, duty, a)) + 0.15 * rng.standard_normal(n)

data = lab.from_arrays(
    t,
    deflection=x + 2e-5 * rng.standard_normal(n),
    deflection_velocity=v + 1e-3 * rng.standard_normal(n),
    duty=duty,
    damper_force=force,
)

# %% [markdown]
# Without the file the lab says that something unknown is left, or that a part of it looks like something else. With it:

# %%
result = lab.diagnose(data, model)
print(result)
assert result.effects[0] == "voltage_crosstalk"
print(*(f"{name} = {value}" for name, value in result.candidates[0].parameters.items()))

# %% [markdown]
# # A first diagnosis, from arrays
#
# A damper was measured: time, deflection, duty and force. Does our model of it lack something?

# %%
import numpy as np

import er_model_lab as lab

# %% [markdown]
# Here the "measurement" is made: the shipped damper with friction that its model does not have, and a noisy load cell.
# With your own data this cell reads your files instead: `data = lab.load("run1.mcap", "run2.csv")`.

# %%
from er_models import motion, predict

rng = np.random.default_rng(1)
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

model = lab.load_model("inove_guo")
truth = model.with_effect("coulomb_friction", {"F_c": 1.0, "v_0": 0.003})
force = predict(truth, motion(dt, x, v, duty, a)) + 0.15 * rng.standard_normal(n)

# %% [markdown]
# Arrays in SI units become a data set. The velocity is derived from the deflection, since none was given.

# %%
data = lab.from_arrays(
    t,
    deflection=x + 2e-5 * rng.standard_normal(n),
    duty=duty,
    damper_force=force,
    sprung_acceleration=a + 0.025 * rng.standard_normal(n),
    unsprung_acceleration=0.025 * rng.standard_normal(n),
)

# %%
before = lab.compare(data, model)
print(before)
result = lab.diagnose(data, model)
print(result)
assert "coulomb_friction" in result.effects or any(
    "coulomb_friction" in group for group in result.alternatives
)

# %% [markdown]
# The evidence is a table: how much each effect lowers the error on data it was not fitted to, and what chance reaches.

# %%
print(result.to_frame().head())
for candidate in result.evidence:
    print(candidate.effect, candidate.status, *map(str, candidate.parameters.values()))

# %% [markdown]
# Where does the model fail? Every picture of the report is one call away; in a notebook it shows itself.

# %%
print(result.figures)
figure = result.figure("residual_maps")

# %% [markdown]
# The model with what was found, ready to be saved and used.

# %%
better = lab.add(data, model, "coulomb_friction")
print(better)
print(better.model.value("coulomb_friction", "F_c"), "N, true: 1 N")

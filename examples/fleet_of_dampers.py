# %% [markdown]
# # Which dampers of a fleet differ, and since when?
#
# Six dampers of one kind are recorded every 20 000 km. One of them loses a fifth of its damping at 60 000 km.
# Which one, in what, and where?

# %%
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd
from er_models.prediction import motion, predict

import er_model_lab as lab

model = lab.load_model("inove_guo")
passive = model.effects["passive"]
rng = np.random.default_rng(2)
t = 0.005 * np.arange(1200)
w = 2.0 * np.pi * np.array([0.7, 1.3, 2.1, 3.4, 5.2])


def recording(c0: float) -> pd.DataFrame:
    """Six seconds of a damper with this damping [N s/m], as a rig would record them."""
    phase = np.add.outer(w, np.zeros(t.size)) * t + rng.uniform(0.0, 2.0 * np.pi, (w.size, 1))
    size = 0.04 / w[:, None]
    x, v, a = (size * w[:, None] ** k * np.sin(phase + k * np.pi / 2) for k in range(3))
    x, v, a = x.sum(0), v.sum(0), a.sum(0)
    duty = np.repeat(rng.choice([0.0, 0.1, 0.2, 0.3], 8), 150)
    damper = model.with_effect("passive", {**passive, "c0": c0})
    force = predict(damper, motion(0.005, x, v, duty, a)) + 0.15 * rng.standard_normal(t.size)
    return pd.DataFrame({"t": t, "deflection": x, "deflection_velocity": v, "duty": duty, "damper_force": force})


# %% [markdown]
# A table says which recording belongs to which unit, and how far it had run. `lab.fleet` reads it. Here two threads do
# the work; without `executor` processes of Dask do it, or a cluster by its address.

# %%
with TemporaryDirectory() as place:
    rows = []
    for unit in "ABCDEF":
        own = passive["c0"] * (1.0 + 0.03 * rng.standard_normal())
        for mileage in range(0, 120_000, 20_000):
            leak = 0.8 if unit == "D" and mileage >= 60_000 else 1.0
            name = f"{unit}{mileage}.parquet"
            recording(own * leak).to_parquet(Path(place) / name)
            rows.append({"path": name, "unit": unit, "mileage [km]": mileage})
    table = Path(place) / "drives.csv"
    pd.DataFrame(rows).to_csv(table, index=False)
    with ThreadPoolExecutor(2) as pool:
        result = lab.fleet(
            table, model, out=Path(place) / "fleet.parquet", search=False, executor=pool
        )
    units = pd.read_parquet(Path(place) / "fleet.parquet").set_index("unit")

# %% [markdown]
# What differs, and since when. Of the units that are named, one in twenty is named by chance.

# %%
print(result)
print(units[["differs", "differs_in", "passive.c0", "passive.c0_pooled"]].round(1))
for change in units.loc["D", "changes"]:
    print(f"{change['quantity']}: a {change['form']} at {change['at'] / 1e3:.0f} km")

# %%
assert units.loc["D", "differs"]

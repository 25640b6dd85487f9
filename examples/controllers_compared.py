# %% [markdown]
# # Controllers compared, with a leak
#
# A quarter car on a bumpy road, its damper leaking: what do a constant duty, Skyhook and the fault-tolerant LPV
# controller make of it? Each sees the same noisy sensors; the LPV controller is told of the fault.

# %%
from pathlib import Path

import numpy as np
from er_models import load_model
from er_models.program import within
from er_models.road import road_profile
from er_studies.control.closed_loop import Sensors, drive, known
from er_studies.control.run import setup

root = Path(__file__).resolve().parents[1] if "__file__" in globals() else Path()
given = setup(root / "config")
healthy = load_model(root / "config" / "vehicles" / "inove_quarter_car.yaml")
leaking = healthy.with_effect("oil_leakage", {"f": 0.6})

# %%
dt, n = 0.005, 3000
road = road_profile(  # at every step of the integrator
    {"kind": "iso8608", "road_class": "A", "speed": 10.0, "factor": 0.3}, within(n, dt), seed=2
)


class Calm:
    """Limits that a scenario would give."""

    duty_max, latency = 0.3, 0


# %%
deflection = {}
for name in ("passive", "skyhook", "fault_tolerant"):
    law = given.law(name, Calm)
    record = drive(leaking, road, dt, law, known(given.model, leaking), Sensors(), 1)
    deflection[name] = float(np.sqrt(np.mean(record["deflection"] ** 2)))
    comfort = float(np.sqrt(np.mean(record["sprung_acceleration"] ** 2)))
    print(
        f"{name:15s} deflection {1e3 * deflection[name]:.2f} mm, body acceleration {comfort:.2f} m/s2"
    )

assert deflection["fault_tolerant"] < deflection["passive"]

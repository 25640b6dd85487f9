# %% [markdown]
# # A synthesis and its certificate
#
# Observer gains come from linear matrix inequalities. What the solver returns is not believed: it is proved with exact
# margins, and the certificate says what was proved.

# %%
from pathlib import Path

from er_models import load_model

import er_observers as observers

root = Path(__file__).resolve().parents[1] if "__file__" in globals() else Path()
car = load_model(root / "config" / "vehicles" / "inove_quarter_car.yaml")

# %%
claim, certificate = observers.synthesise("nlpv_polytopic", car)
print(certificate.margins)
print(f"slowest pole {certificate.slowest:.1f} 1/s; measured peak gain {certificate.peak}")
assert certificate.slowest < 0.0

# %% [markdown]
# Saved gains carry the certificate. A node proves it again when it loads them, and refuses gains of another model.

# %%
shipped = observers.load_gains(root / "config" / "gains" / "nlpv_polytopic.yaml", car)
heavy = car.with_effect("quarter_car", {**car.effects["quarter_car"], "m_s": 9.0})
try:
    observers.load_gains(root / "config" / "gains" / "nlpv_polytopic.yaml", heavy)
except Exception as refused:
    print("refused:", refused)
else:
    raise AssertionError("gains of another car were taken")

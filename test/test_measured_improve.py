"""What `improve` does to a small part of each measured set: the error on runs that it never used falls."""

import numpy as np
import pytest
from er_model_lab.diagnosis import evidence, investigation
from er_model_lab.level.damper import DamperLevel
from er_model_lab.level.investigate import Question, investigate
from er_model_lab.preflight.check import preflight
from er_model_lab.problem.forward import DamperForward
from er_models.files import load_model
from er_records.dataset import Dataset
from er_studies.importers.data_sets import import_data

from test.conftest import ROOT

DATA = ROOT.parent / "shared" / "data"
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not DATA.is_dir(), reason="the measured data are not beside the repository"
    ),
]
SECONDS, MOST = 5.0, 10
TRIED = (
    "deflection_zero",
    "force_delay",
    "gas_spring",
    "coulomb_friction",
    "preload",
    "position_dependent_damping",
)
"""Effects that are asked, for the sake of time: of sensors, of field-free forces, and of a place."""
PARTS = {
    "mts": ("mr_damper_mts", ("ME2mm5Hz.txt", "ME5mm3Hz.txt")),
    "shaking_table": (
        "mr_damper_shaking_table",
        tuple(f"ensaio{name}.mat" for name in ("1.1", "10.2", ".A.1", ".A.10", ".B.1", ".B.8")),
    ),
    "piston_seal": (
        "piston_seal_friction",
        ("O-ring257_1bar.csv", "O-ring257_7bar.csv", "X-ring257_3bar.csv"),
    ),
}


def runs(kind):
    """The first seconds of some runs."""
    folder, names = PARTS[kind]
    whole = [r for name in names for r in import_data(kind, DATA / folder / name)]
    long = [r for r in whole if len(r) * r.dt > SECONDS]
    return [r.slice(0, round(SECONDS / r.dt)) for r in long[:: -(-len(long) // MOST)]]


@pytest.mark.parametrize("kind", PARTS)
def test_the_error_on_runs_held_out_falls(kind, monkeypatch):
    """One round of the search: what it adds pays on runs that nothing was fitted to or chosen by."""
    for module in (investigation, evidence):
        monkeypatch.setattr(module, "MOST_EFFECTS", 1)
    monkeypatch.setattr(
        DamperForward, "candidates", lambda _, model: tuple(model.catalogue[n] for n in TRIED)
    )
    model = load_model(ROOT / "config/dampers/inove_guo.yaml")
    data = Dataset.of(runs(kind))
    study = investigate(Question(data, model, DamperLevel(), preflight(data.records), seed=1))
    found, held = study.diagnosis, study.problem.held_out
    before, after = (
        float(np.sqrt(np.mean(c.fit.residual[held] ** 2))) for c in (found.base, found.best)
    )
    print(
        kind, study.problem.motion.n, before, after, found.verdict, found.effects, found.explained
    )
    assert found.effects
    assert after < 0.9 * before

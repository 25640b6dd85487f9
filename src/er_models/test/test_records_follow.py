"""Heat and time go on between records that follow one another, whichever of them stands first."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from er_models.model import Model
from er_models.prediction import Told, join, motion, predict
from models_help import DT, SMALL

WARM = {
    "passive": {"k0": 100.0, "c0": 50.0},
    "self_heating": {"t_h": 8.0, "b_v": 0.5, "b_y": 0.0},
    "force_fade": {"s": 0.3, "t_f": 6.0},
}
MODEL = Model("warm", WARM, SMALL)
CUT = 2000


def parts(*ends: tuple[int, int]):
    """Pieces of one long sine."""
    t = np.arange(4001) * DT
    x, v, a = (
        0.01 * 12.0**k * y
        for k, y in enumerate((np.sin(12.0 * t), np.cos(12.0 * t), -np.sin(12.0 * t)))
    )
    return join([motion(DT, x[i:j], v[i:j], 0.0 * t[i:j], a[i:j]) for i, j in ends])


WHOLE = predict(MODEL, parts((0, 4001)))


@pytest.mark.parametrize("told", [False, True])
def test_a_record_goes_on_where_the_one_before_it_ended(told: bool) -> None:
    two = parts((CUT, 4001), (0, CUT + 1))
    began = replace(two, began=np.array([CUT * DT, 0.0]))
    seen = (
        Told(np.concatenate([WHOLE[CUT:], WHOLE[: CUT + 1]]), np.ones(two.n), 60) if told else None
    )
    force = predict(MODEL, began, seen)
    assert np.abs(force[: 4001 - CUT] - WHOLE[CUT:]).max() < 1e-9
    assert np.abs(force[4001 - CUT :] - WHOLE[: CUT + 1]).max() < 1e-9
    anew = predict(MODEL, two, seen)
    assert np.abs(anew[: 4001 - CUT] - WHOLE[CUT:]).max() > 1.0
    assert np.array_equal(began.t[: 4001 - CUT], CUT * DT + np.arange(4001 - CUT) * DT)


def test_heat_leaves_in_a_pause_and_time_goes_on() -> None:
    two, pause = parts((0, CUT + 1), (CUT, 4001)), 8.0 * np.log(2.0)
    later = replace(two, began=np.array([0.0, (CUT + 1) * DT + pause]))
    heat = Model("hot", {k: WARM[k] for k in ("passive", "self_heating")}, SMALL)
    first, at_once, half = (
        predict(heat, replace(two, began=b))
        for b in (None, np.array([0.0, CUT * DT]), later.began)
    )
    cold, hot, between = (np.log(np.abs(f[CUT + 1])) for f in (first, at_once, half))
    assert between - cold == pytest.approx(0.5 * (hot - cold), rel=1e-2)
    fades = Model("old", {"passive": WARM["passive"], "force_fade": WARM["force_fade"]}, SMALL)
    share = predict(fades, later)[CUT + 1] / predict(fades, two)[CUT + 1]
    assert share == pytest.approx(1.0 - 0.3 * (1.0 - np.exp(-later.began[1] / 6.0)), rel=1e-6)

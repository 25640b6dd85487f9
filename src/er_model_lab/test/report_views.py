"""A view to draw: a damper with Coulomb friction that its model does not know."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
from er_model_lab.residual.region import Region, RegionTable
from er_model_lab.view import Array, CandidateView, ImitationView, ProgramView, RecordView, View
from er_models.catalogue import CATALOGUE

NOISE = 0.2


def record(
    name: str, seconds: float, seed: int, *, held_out: bool = False, after: bool = True
) -> RecordView:
    """Sines of three frequencies and a duty in steps, at 200 Hz."""
    rng = np.random.default_rng(seed)
    t = np.arange(int(200 * seconds)) / 200.0
    tones = [(1.3, 4e-3), (3.1, 1e-3), (5.7, 4e-4)]
    phases = rng.uniform(0, 6, 3)
    x = sum(a * np.sin(2 * np.pi * f * t + p) for (f, a), p in zip(tones, phases, strict=True))
    v = sum(
        2 * np.pi * f * a * np.cos(2 * np.pi * f * t + p)
        for (f, a), p in zip(tones, phases, strict=True)
    )
    u = np.repeat(rng.uniform(0, 0.3, t.size // 160 + 1), 160)[: t.size]
    rest = 64.0 * v + 200.0 * x + 29.0 * u * np.tanh(400.0 * v)
    friction = 0.9 * np.tanh(v / 3e-3)
    measured = rest + friction + NOISE * rng.standard_normal(t.size)
    before = rest + 14.0 * v
    scored = t > 0.3
    held = scored if held_out else np.zeros(t.size, bool)
    return RecordView(
        name, t, x, v, u, measured, before, rest + friction if after else None, scored, held
    )


def table(
    quantity: str, unit: str, edges: list[float], rms: list[float], shares: list[float]
) -> RegionTable:
    """Bins between edges; equal shares of the samples."""
    pairs = list(itertools.pairwise(edges))
    regions = tuple(
        Region(
            quantity,
            unit,
            pair,
            share,
            1 / len(pairs),
            r,
            (0.9 * r, 1.1 * r),
            NOISE,
            (r**2 - NOISE**2) ** 0.5,
            ((0.8 * r**2 - NOISE**2) ** 0.5, (1.2 * r**2 - NOISE**2) ** 0.5),
        )
        for pair, r, share in zip(pairs, rms, shares, strict=True)
    )
    return RegionTable(quantity, unit, regions)


TABLES = (
    table(
        "velocity",
        "m/s",
        [-0.1, -0.02, 0.0, 0.02, 0.1],
        [0.4, 0.7, 0.9, 0.4],
        [0.1, 0.25, 0.55, 0.1],
    ),
    table("duty", "1", [0.0, 0.1, 0.2, 0.2], [0.5, 0.5, 0.5], [0.33, 0.33, 0.34]),
)

EFFECTS = {"coulomb_friction": 0.51, "shear_thinning": 0.3, "end_stop": 0.05, "force_lag": -0.01}


def entry(effect: str, size: float) -> dict[str, object]:
    """One candidate of the result."""
    status = {"coulomb_friction": "present", "end_stop": "not_excited"}.get(effect, "absent")
    return {
        "effect": effect, "rmse_held_out": 0.55 - size / 2, "evidence": size, "threshold": 0.022,
        "p_value": 0.059,
        "parameters": {"F_c": [0.936, 0.0088, "N"], "v_0": [0.0032, None, "m/s"]},
        "status": status,
        "confounded_with": [], "explained_by": ["coulomb_friction"] if effect == "shear_thinning" else [],
        "explains": 0.97, "kept_fraction": 0.5,
    }  # fmt: skip


PARAMETERS: dict[str, object] = {
    "passive": {
        "k0": {
            "value": 8.957e6, "sd": 8.8e5, "unit": "N/m", "before": 2.6e5, "bounds": [0.0, 1e7], "status": "identified",
        },
        "c0": {"value": 64.6, "sd": None, "unit": "N s/m", "before": 64.6, "bounds": [0.0, 9e3], "status": "at_bound"},
    },
    "coulomb_friction": {
        "F_c": {"value": 0.936, "sd": 0.0088, "unit": "N", "before": None, "bounds": [0.0, 42.0], "status": "added"},
        "v_0": {
            "value": 0.0032, "sd": None, "unit": "m/s", "before": None, "bounds": [3e-4, 0.02],
            "status": "not_identified",
        },
    },
}  # fmt: skip
"""Parameters before and after."""

FLOORS: dict[str, object] = {
    "standstill": {"value": None, "sd": None, "says": "no rest of 0.3 s or more in these records"},
    "repeats": {"value": 0.19, "sd": 0.01, "says": "900 samples that repeat others"},
    "force_white": {"value": 0.15, "sd": None, "says": "white part of what is left"},
    "bound": {"value": 0.2, "sd": None, "says": "what trees and filters cannot explain"},
}

HISTORY = [
    {
        "added": ["coulomb_friction"], "verdict": "missing_effect", "records": ["r"], "data": "abc", "seed": 1,
        "rmse_held_out": {"before": 0.5, "after": 0.2}, "noise_floor": 0.19, "from": "inove_guo",
    },
]  # fmt: skip
MODELS = [
    {
        "model": name, "model_file": f"{name}.yaml", "rmse": rmse, "nrmse": 0.03, "explainable": 0.5,
        "against_first": {"change": rmse - 0.6, "band": [rmse - 0.62, rmse - 0.58]}, "effects": ["passive"],
        "rmse_by_record": {"record_1": rmse, "record_2": rmse}, "fitted_to_these_data": name == "new",
    }
    for name, rmse in (("inove_guo", 0.6), ("new", 0.2))
]  # fmt: skip

FUSION: dict[str, object] = {
    "channels": ["acceleration", "deflection"],
    "sd": {"deflection": 5e-6, "velocity": 2e-4, "acceleration": 0.01},
    "noise": {"deflection": 2e-5, "velocity": None, "acceleration": 0.03},
    "bias": {
        "sprung_acceleration": {"value": 0.05, "sd": 0.002, "says": "biased"},
        "unsprung_acceleration": {"value": None, "sd": None, "says": "channel absent"},
        "relative": {"value": -0.08, "sd": 0.0005, "says": "biased"},
    },
    "lost": ["without a velocity channel its lag and gain cannot be checked"],
}

PREFLIGHT: dict[str, object] = {
    "passed": False,
    "findings": [
        {
            "check": "units", "level": "fail", "record": "record_1", "channel": "deflection", "expected": "m",
            "found": "a channel that looks like mm beside deflection_velocity", "remedy": "convert deflection to m",
        },
        {
            "check": "held", "level": "ok", "record": "record_1", "channel": "", "expected": "no repeats",
            "found": "no repeats", "remedy": "",
        },
    ],
    "reach": {"deflection": 0.006, "velocity": 0.1, "duty": 0.3, "known_from": "the data"},
    "cells": [
        {
            "name": "far_extension", "region": "deflection beyond 70 %", "need": 0.3, "unit": "s", "have": 0.1,
            "covered": False, "effects": ["end_stop"],
        },
    ],
    "missing": {"end_stop": ["far_extension"]},
    "maps": [
        {
            "x": "velocity", "x_unit": "m/s", "x_edges": [-0.1, 0.0, 0.1], "y": "duty", "y_unit": "1",
            "y_edges": [0.0, 0.1, 0.3], "seconds": [[1.0, 0.0], [2.0, 3.0]],
        },
        {
            "x": "duty rate", "x_unit": "1/s", "x_edges": [-1.0, 0.0, 1.0], "y": "", "y_unit": "", "y_edges": [],
            "seconds": [[1.0, 5.0]],
        },
    ],
}  # fmt: skip

IDENTIFIED: dict[str, object] = {
    "parameters": {
        "guo_yield": {
            "f_c": {
                "value": 29.3, "sd": 0.01, "unit": "N/duty", "before": 30.0, "status": "identified", "visible": 0.3,
            },
            "c1": {"value": 490.0, "sd": 11.0, "unit": "s/m", "before": 500.0, "status": "weak", "visible": 0.004},
            "k1": {"value": 204.0, "sd": None, "unit": "1/m", "before": 204.0, "status": "not_identified"},
        },
        "passive": {
            "k0": {"value": 9.9, "sd": None, "unit": "N/m", "before": 9.9, "status": "at_bound", "visible": 0.1},
        },
    },
    "correlation": {
        "names": ["guo_yield.f_c", "guo_yield.c1", "passive.k0"],
        "matrix": [[1.0, 0.97, None], [0.97, 1.0, None], [None, None, None]],
    },
    "stages": [
        {"stage": "linear", "done": False, "why": "no stretch at zero duty"},
        {
            "stage": "yield", "done": True, "samples": 900, "rmse": 0.5,
            "parameters": {"guo_yield.c1": [90.0, 2.0, "s/m"]},
        },
    ],
    "response_time": {
        "levels": [{"duty": 0.1, "tau": 0.02, "sd": 1e-4}, {"duty": 0.3, "tau": 0.06, "sd": None}],
        "model": {"duty": [0.0, 0.3], "tau": [0.04, 0.04]},
        "quadratic": {"tau_0": [0.0, 0.1, "s"], "tau_1": [0.2, 0.1, "s/duty"], "tau_2": [0.0, 0.1, "s/duty2"]},
    },
}  # fmt: skip
"""What `lab identify` adds to a result."""


PLANNED: dict[str, object] = {
    "between": ["coulomb_friction", "shear_thinning"],
    "why": ["What the best imitation leaves is 2 times the noise.", "The program repeats every 8 s."],
    "programs": [
        {
            "name": f"program {k}", "separation": {"coulomb_friction": 3.3, "shear_thinning": 2.0 / k},
            "used": {"stroke": 0.0116, "velocity": 0.149, "duty": 0.3, "road": 0.03},
        }
        for k in (1, 2)
    ],
    "identification": {
        "name": "identification", "separation": {"coulomb_friction": 0.1, "shear_thinning": 0.02},
        "used": {"stroke": 0.004, "velocity": 0.149, "duty": 0.27, "road": 0.02},
    },
    "measurements": {e: {"right": 5, "runs": 5} for e in ("coulomb_friction", "shear_thinning")},
    "measurements_identification": {e: {"right": 1, "runs": 5} for e in ("coulomb_friction", "shear_thinning")},
    "strengths": {
        e: {"parameters": {"F_c": [0.23, None, "N"]}, "source": "fitted to the data"}
        for e in ("coulomb_friction", "shear_thinning")
    },
    "program_file": "next.yaml",
}  # fmt: skip
"""What `lab plan` adds to a result."""


def program(name: str, r: RecordView) -> ProgramView:
    """A planned program along the motion of a record."""
    both = (("Coulomb friction", "Shear thinning"), ("Shear thinning", "Coulomb friction"))
    found = tuple(ImitationView(a, b, r.measured, r.before, NOISE) for a, b in both)
    return ProgramView(name, r.t, -2.0 * r.deflection, r.deflection, r.duty, 4.0, found)


def card(effect: str, size: float, r: RecordView) -> CandidateView:
    """Evidence of one candidate."""
    rows = slice(100, None, 17)
    change = size * np.tanh(r.velocity[rows] / 3e-3)
    return CandidateView(
        effect, effect.replace("_", " ").capitalize(), "Seals rub.",
        CATALOGUE, "jumps with the sign",
        f"experiment for {effect}", entry(effect, size), "taken: lowers the error",
        "force-velocity", r.velocity[rows],
        change, (r.measured - r.before)[rows],
    )  # fmt: skip


def view(seconds: float = 12.0, records: int = 2, **result: object) -> View:
    """The view of `lab diagnose`; keywords replace entries of the result, None takes them out."""
    views = tuple(
        record(f"record_{k + 1}", seconds, k, held_out=k == records - 1) for k in range(records)
    )
    content = {
        "command": "diagnose", "verdict": "missing_effect", "effects": ["coulomb_friction"],
        "alternatives": [],
        "noise_floor": NOISE, "floors": FLOORS, "rmse": {"train": 0.61, "held_out": 0.6}, "nrmse": {"train": 0.03,
        "held_out": 0.029},
        "rmse_after": {"train": 0.21, "held_out": 0.2}, "explainable": 0.89, "explained": 0.99,
        "candidates": [entry(e, s) for e, s in EFFECTS.items()],
        "unknowable": [{"effect": "force_gain", "because": "the damper's forces scale along."}],
        "reasons": ["error 0.6 N after refitting"],
        "parameters": PARAMETERS,
        "steps": [{"added": None, "rmse_held_out": 0.6}, {"added": "coulomb_friction",
        "rmse_held_out": 0.2}],
    } | result  # fmt: skip
    return View(
        command="diagnose", model="inove_guo",
        headline="unexplained 0.6 N, noise 0.2 N, model 0.566 N",
        result={k: v for k, v in content.items() if v is not None}, records=views, regions=TABLES,
        candidates=tuple(card(e, s, views[0]) for e, s in EFFECTS.items()),
        notes=("velocity derived from deflection",),
        provenance={"seed": 7, "model_file": "inove_guo.yaml", "versions": {"numpy": "2.0"}},
    )  # fmt: skip


def compared(seconds: float = 12.0) -> View:
    """The view of `lab compare`: no verdict, nothing added."""
    full = view(seconds)
    result = {
        "rmse": 0.6,
        "nrmse": 0.03,
        "noise_floor": NOISE,
        "explainable": 0.89,
        "worst": [],
        "floors": FLOORS,
    }
    records = tuple(replace(r, after=None) for r in full.records)
    return replace(full, command="compare", result=result, records=records, candidates=())


def empty() -> View:
    """A view with a headline and nothing else."""
    return View("compare", "inove_guo", "unexplained 0.6 N", {"noise_floor": None}, ())


def rms(y: Array) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(y**2)))

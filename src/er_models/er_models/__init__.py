"""Models of semi-active dampers and quarter cars, composed of physical effects: prediction, simulation, linear forms.

    import er_models

    model = er_models.load_model("inove_guo")                      # a shipped name, or a path
    force = er_models.predict(model, er_models.motion(dt, x, v, duty))              # (n,) [N]
    worn = model.with_effect("coulomb_friction", {"F_c": 1.0, "v_0": 0.003})
    for effect in er_models.effects(): print(effect.name, effect.title)

    car = er_models.load_model("inove_quarter_car")
    road = er_models.road_profile({"kind": "iso8608", "road_class": "C", "speed": 15.0}, t)
    record = er_models.simulate(car, dt, road, duty)               # channels by name, (n,) each
    form = er_models.linearise(car)                                # matrices A, B, C, ... around one tanh

SI units throughout: m, m/s, m/s2, N, s, K; duty 0 to 1. Deflection and force are positive in extension, where a force
above zero resists. No ROS, no plots, no solver of matrix inequalities is imported, here or later.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from er_models.lazy import lazy

if TYPE_CHECKING:
    from er_models.catalogue import Catalogue as Catalogue
    from er_models.duty import duty_profile as duty_profile
    from er_models.effect import Effect as Effect
    from er_models.effect import Param as Param
    from er_models.effect import Signature as Signature
    from er_models.errors import ErError as ErError
    from er_models.errors import InputError as InputError
    from er_models.errors import MissingChannel as MissingChannel
    from er_models.errors import UnknownName as UnknownName
    from er_models.files import load_model as load_model
    from er_models.files import save_model as save_model
    from er_models.forms.linearise import NotThisForm as NotThisForm
    from er_models.forms.lipschitz import LinearForm as LinearForm
    from er_models.forms.lipschitz import linearise as linearise
    from er_models.model import Model as Model
    from er_models.own import effects as effects
    from er_models.prediction import Motion as Motion
    from er_models.prediction import join as join
    from er_models.prediction import motion as motion
    from er_models.prediction import predict as predict
    from er_models.prediction import predict_many as predict_many
    from er_models.program import Program as Program
    from er_models.program import load_program as load_program
    from er_models.road import road_profile as road_profile
    from er_models.scales import Scales as Scales
    from er_models.simulation import Output as Output
    from er_models.simulation import Plant as Plant
    from er_models.simulation import State as State
    from er_models.simulation import initial_state as initial_state
    from er_models.simulation import prepare as prepare
    from er_models.simulation import simulate as simulate
    from er_models.simulation import step as step
    from er_models.version import __version__ as __version__
else:
    __all__, __getattr__, __dir__ = lazy(
        __name__,
        {
            "er_models.catalogue": ["Catalogue"],
            "er_models.duty": ["duty_profile"],
            "er_models.effect": ["Effect", "Param", "Signature"],
            "er_models.errors": ["ErError", "InputError", "MissingChannel", "UnknownName"],
            "er_models.files": ["load_model", "save_model"],
            "er_models.forms.linearise": ["NotThisForm"],
            "er_models.forms.lipschitz": ["LinearForm", "linearise"],
            "er_models.model": ["Model"],
            "er_models.own": ["effects"],
            "er_models.prediction": ["Motion", "join", "motion", "predict", "predict_many"],
            "er_models.program": ["Program", "load_program"],
            "er_models.road": ["road_profile"],
            "er_models.scales": ["Scales"],
            "er_models.simulation": [
                *("Output", "Plant", "State"),
                *("initial_state", "prepare", "simulate", "step"),
            ],
            "er_models.version": ["__version__"],
        },
    )

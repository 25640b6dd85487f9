"""The fault-tolerant controller of a semi-active damper: one pure step, its gains, and how they are made.

    import er_ftc_controller as ftc

    gains = ftc.load_gains("lpv_ftc", model)                        # shipped gains, or a path; proved again
    belief = dict(largest_deflection=0.05, largest_velocity=5.0)                       # m, m/s
    given = ftc.FtcParameters(u_min=0.0, u_max=0.3, safe_duty=0.1, mu=1.6, **belief)   # mu: N
    controller = ftc.controller_of(given, model, gains)
    state = ftc.start(controller)
    state = ftc.hear(controller, state, ftc.Faults(t, 1.0, 0.6, 1.0, certain=True, usable=True))
    state, command = ftc.step(controller, state, t, ftc.Sample(deflection, velocity))
    command.duty, command.mode                                                         # 0 to 1; NOMINAL, ...

    plant, solution, certificate = ftc.synthesise(model)                               # needs cvxpy, imported here

SI units throughout: m, m/s, m/s2, N, s; duty 0 to 1. Deflection and force are positive in extension. In the loop
nothing raises: what is wrong is the mode of a command, with its reason. Nothing here needs ROS. Equations:
docs/control.md.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from er_models.lazy import lazy

if TYPE_CHECKING:
    from er_models.version import __version__ as __version__

    from er_ftc_controller.control import Command as Command
    from er_ftc_controller.control import Faults as Faults
    from er_ftc_controller.control import Ftc as Ftc
    from er_ftc_controller.control import Mode as Mode
    from er_ftc_controller.control import Rules as Rules
    from er_ftc_controller.control import Sample as Sample
    from er_ftc_controller.control import State as State
    from er_ftc_controller.control import hear as hear
    from er_ftc_controller.control import start as start
    from er_ftc_controller.control import step as step
    from er_ftc_controller.gains import Loaded as Loaded
    from er_ftc_controller.gains import load_gains as load_gains
    from er_ftc_controller.gains import save_gains as save_gains
    from er_ftc_controller.settings import FtcParameters as FtcParameters
    from er_ftc_controller.settings import controller_of as controller_of
    from er_ftc_controller.synthesis.certificate import Certificate as Certificate
    from er_ftc_controller.synthesis.lmi import Wish as Wish
    from er_ftc_controller.synthesis.make import Design as Design
    from er_ftc_controller.synthesis.make import synthesise as synthesise
    from er_ftc_controller.synthesis.solution import NoController as NoController
    from er_ftc_controller.synthesis.solution import Solution as Solution
    from er_ftc_controller.synthesis.weights import Plant as Plant
    from er_ftc_controller.synthesis.weights import Weights as Weights
else:
    __all__, __getattr__, __dir__ = lazy(
        __name__,
        {
            "er_ftc_controller.control": [
                *("Command", "Faults", "Ftc", "Mode", "Rules", "Sample", "State"),
                *("hear", "start", "step"),
            ],
            "er_ftc_controller.gains": ["Loaded", "load_gains", "save_gains"],
            "er_ftc_controller.settings": ["FtcParameters", "controller_of"],
            "er_ftc_controller.synthesis.certificate": ["Certificate"],
            "er_ftc_controller.synthesis.lmi": ["Wish"],
            "er_ftc_controller.synthesis.make": ["Design", "synthesise"],
            "er_ftc_controller.synthesis.solution": ["NoController", "Solution"],
            "er_ftc_controller.synthesis.weights": ["Plant", "Weights"],
            "er_models.version": ["__version__"],
        },
    )

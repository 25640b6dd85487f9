"""Observers of the damper force from two accelerometers: proved gains, one pure step, and how gains are made.

    import er_observers as observers

    gains = observers.ready("unified", model)        # shipped gains or a path; proved again, and warm
    state = observers.start(gains, observers.Sample(0.0, sprung, unsprung, duty))
    state, estimate = observers.step(gains, state, observers.Sample(0.005, sprung, unsprung, duty))
    estimate.force, estimate.status                                            # N; OK, WEAK, ..., INVALID

    claim, certificate = observers.synthesise("unified", model)                # needs cvxpy, imported here

SI units throughout: m, m/s, m/s2, N, s; duty 0 to 1. Accelerations point upwards, without gravity; force and
deflection are positive in extension. In the loop nothing raises: what is wrong is the status of an estimate.
Nothing here needs ROS. The theorems and their sources: docs/observers.md.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from er_models.lazy import lazy

if TYPE_CHECKING:
    from er_models.version import __version__ as __version__

    from er_observers.gains import Gains as Gains
    from er_observers.gains import load_gains as load_gains
    from er_observers.gains import observer_of as observer_of
    from er_observers.gains import save_gains as save_gains
    from er_observers.observers.payload import Payload as Payload
    from er_observers.observers.status import Limits as Limits
    from er_observers.observers.status import Status as Status
    from er_observers.programs import OBSERVERS as OBSERVERS
    from er_observers.running.ready import ready as ready
    from er_observers.running.runtime import Estimate as Estimate
    from er_observers.running.runtime import Sample as Sample
    from er_observers.running.runtime import State as State
    from er_observers.running.runtime import lose as lose
    from er_observers.running.runtime import payload_of as payload_of
    from er_observers.running.runtime import start as start
    from er_observers.running.runtime import step as step
    from er_observers.synthesis.certify import Certificate as Certificate
    from er_observers.synthesis.make import Wish as Wish
    from er_observers.synthesis.make import synthesise as synthesise
    from er_observers.synthesis.proof import Claim as Claim
    from er_observers.synthesis.spec import Spec as Spec
    from er_observers.synthesis.spec import SynthesisFailed as SynthesisFailed
else:
    __all__, __getattr__, __dir__ = lazy(
        __name__,
        {
            "er_observers.gains": ["Gains", "load_gains", "observer_of", "save_gains"],
            "er_observers.observers.payload": ["Payload"],
            "er_observers.observers.status": ["Limits", "Status"],
            "er_observers.programs": ["OBSERVERS"],
            "er_observers.running.ready": ["ready"],
            "er_observers.running.runtime": [
                *("Estimate", "Sample", "State"),
                *("lose", "payload_of", "start", "step"),
            ],
            "er_observers.synthesis.certify": ["Certificate"],
            "er_observers.synthesis.make": ["Wish", "synthesise"],
            "er_observers.synthesis.proof": ["Claim"],
            "er_observers.synthesis.spec": ["Spec", "SynthesisFailed"],
            "er_models.version": ["__version__"],
        },
    )

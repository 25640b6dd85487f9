"""A run in the middle of a drive: its road and duty instead of the drive's for as long as it takes. Pure."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from er_models.errors import InputError
from er_models.model import Array, Model
from er_models.program import LONGEST, Program, times
from er_models.simulation import simulate

GO_OVER = 1.0
"""Time in which the road goes over to the run's, and back behind it [s]."""
LOOSE = 1.1
"""What a run may reach, as a multiple of the rig's limits: models of one damper differ by as much."""


@dataclass(frozen=True)
class Interlude:
    """A drive with a run in it, as a `Program` is asked; the drive goes on meanwhile, and is where it would have been.

    begin: when the road begins to go over [s]; the duty is the run's from `GO_OVER` later on, until the run ends.
    """

    drive: Program
    run: Program
    begin: float

    @property
    def ends(self) -> float:
        """When the run ends, and the road begins to go back [s]."""
        return self.begin + GO_OVER + self.run.duration

    @property
    def duration(self) -> float:
        """Of the drive, which is not over before the run is [s]; 0: no end."""
        return self.drive.duration and max(self.drive.duration, self.ends + GO_OVER)

    def rules(self, t: float) -> bool:
        """Whether the duty at a time [s] is the run's."""
        return self.begin + GO_OVER <= t < self.ends

    def heights(self, t: Array) -> Array:
        """Road [m] at the times t (n,); it goes over without a step."""
        rise = np.clip((t - self.begin) / GO_OVER, 0.0, 1.0)
        fall = np.clip((self.ends + GO_OVER - t) / GO_OVER, 0.0, 1.0)
        share = np.minimum(rise, fall)
        share = share**2 * (3.0 - 2.0 * share)
        drive = self.drive.heights(t)
        return drive + share * (self.run.heights(self._own(t)) - drive) if share.any() else drive

    def duties(self, t: Array) -> Array:
        """Duty [1] at the times t (n,)."""
        own = (self.begin + GO_OVER <= t) & (t < self.ends)
        drive = self.drive.duties(t)
        return np.where(own, self.run.duties(self._own(t)), drive) if own.any() else drive

    def _own(self, t: Array) -> Array:
        return np.maximum(t - self.begin - GO_OVER, 0.0)


Drive = Program | Interlude
"""What is driven."""


def rules(drive: Drive, t: float) -> bool:
    """Whether the duty at a time [s] is that of a run in the drive."""
    return isinstance(drive, Interlude) and drive.rules(t)


def begun(drive: Drive, run: Program, t: float) -> Interlude:
    """The drive with a run from a time on [s].

    Raises:
        InputError: Another run is under way.
    """
    if isinstance(drive, Interlude):
        if t < drive.ends + GO_OVER:
            left = f"one for another {drive.ends + GO_OVER - t:.1f} s"
            raise InputError(run.name, "planned_file", "no run under way: empty ends it", left)
        drive = drive.drive
    return Interlude(drive, run, t)


def ended(drive: Drive, t: float) -> Drive:
    """The drive whose run, if there is one under way, ends at a time [s]."""
    if not isinstance(drive, Interlude):
        return drive
    driven = min(max(t - drive.begin - GO_OVER, 0.0), drive.run.duration)
    return replace(drive, run=replace(drive.run, duration=driven))


def check_run(run: Program, model: Model, dt: float, name: str) -> None:
    """Refuse a run that has no end, or takes the car beyond the limits of its rig by more than `LOOSE`.

    model: the car, from rest, its limits in `rig`; dt: of the samples [s], between which the road is taken as straight;
    name: of the file.

    Raises:
        InputError: It does, or it moves no car.
    """
    if run.duration <= 0.0:
        raise InputError(name, "duration", "a run that ends", f"{run.duration:g} s")
    road, duty = run.signals(times(min(run.duration, LONGEST), dt))
    moved = simulate(model, dt, road, np.clip(duty, 0.0, 1.0))
    reached = {
        "stroke": (moved["deflection"], "m of deflection"),
        "velocity_max": (moved["deflection_velocity"], "m/s of deflection"),
        "duty_max": (duty, "of duty"),
        "road": (road, "m of road"),
    }
    for key, (values, unit) in reached.items():
        peak, limit = float(np.abs(values).max()), model.rig.get(key, np.inf)
        if not peak <= LOOSE * limit:
            raise InputError(name, f"rig: {key}", f"at most {limit:.4g} {unit}", f"{peak:.4g}")

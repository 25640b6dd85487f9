"""What a measurement is: one time axis and channels in SI units, with where they come from.

Signs follow the project's convention: deflection is positive in extension, a positive damper force
resists extension, accelerations are those of the motion itself (gravity removed), positive
upwards.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
from er_models.errors import InputError, MissingChannel

from er_records.timing import Timing

Array = npt.NDArray[np.float64]

CHANNELS: dict[str, str] = {
    "road": "m",
    "deflection": "m",
    "deflection_velocity": "m/s",
    "duty": "1",
    "damper_force": "N",
    "sprung_acceleration": "m/s2",
    "unsprung_acceleration": "m/s2",
    "temperature": "K",
    "actuator_force": "N",
    "sprung_displacement": "m",
    "unsprung_displacement": "m",
}
"""Channels of the contract and their units; the time axis `t` [s] stands beside them."""

EXTRA_UNITS: dict[str, str] = {"pressure": "Pa", "deflection_acceleration": "m/s2"}
"""Channels kept beside the contract's; so are estimates named `force_<observer>` [N]."""

HELD: frozenset[str] = frozenset({"duty"})
"""Channels that are constant between samples (zero-order hold): never interpolated linearly."""


def unit_of(name: str) -> str | None:
    """SI unit of a contract or extra channel; None if the name is neither."""
    if name in CHANNELS:
        return CHANNELS[name]
    if name in EXTRA_UNITS:
        return EXTRA_UNITS[name]
    return "N" if name.startswith("force_") else None


def cure(path: str | Path) -> str:
    """What mends wrong columns: of a file a command, of a table in memory an argument."""
    if not Path(path).exists():
        return "say what its columns are: names={'damper_force': 'Kraft [kN]'}"
    return f"say what its columns are: ./er lab map {shlex.quote(str(path))}"


def is_core(name: str) -> bool:
    """Whether the channel is one of the contract's; only these are promised finite."""
    return name in CHANNELS


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """One measurement; immutable, arrays are read-only.

    What `load` returns has t strictly increasing, equally spaced within 10 %, and finite contract
    channels. Extra channels (`force_*`, `pressure`) may hold NaN where their source was not valid.

    Attributes:
        name: Short and unique within a data set.
        t: Time (N,) [s]; starts where the file starts.
        channels: Name to samples (N,), units as `CHANNELS`; duty in row k holds until row k + 1.
        notes: Plain sentences: what was derived, repaired, dropped, scaled.
        complete: False when data were lost or cut; results must say so (exit status 3).
        source: Where the data come from: a path, or a citation for imported data.
        digest: SHA-256 of the bytes first read.
        scales: What 1.0 of a scaled channel means, for instance {"duty": "1 = 1.0 A"}.
        derived: Channels that were computed from others, not measured.
        licence: Licence of the data; empty when not known.
        waits: Of a bag, time from stamp to arrival of each topic [s]: median and 90 % spread.
        timing: How it was sampled before any repair; None when it was not loaded.
        file: File or folder it was read from; empty where it was not.
        wild: Channel to the mask (N,) of its samples that are no measurements; None: nobody has looked.
    """

    name: str
    t: Array
    channels: Mapping[str, Array]
    notes: tuple[str, ...] = ()
    complete: bool = True
    source: str = ""
    digest: str = ""
    scales: Mapping[str, str] = field(default_factory=dict)
    derived: tuple[str, ...] = ()
    licence: str = ""
    timing: Timing | None = None
    waits: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    file: str = ""
    wild: Mapping[str, npt.NDArray[np.bool_]] | None = None

    def __post_init__(self) -> None:
        t = _frozen(self.t)
        channels = {name: _frozen(samples) for name, samples in self.channels.items()}
        for name, samples in {"t": t, **channels}.items():
            if samples.ndim != 1 or samples.size != t.size:
                raise InputError(
                    self.source or self.name,
                    name,
                    f"{t.size} samples as in t",
                    f"shape {samples.shape}",
                )
        object.__setattr__(self, "t", t)
        object.__setattr__(self, "channels", channels)

    def __len__(self) -> int:
        return int(self.t.size)

    @property
    def dt(self) -> float:
        """Median sample time [s]; `InputError` when there are fewer than two samples."""
        if len(self) < 2:
            raise InputError(self.source or self.name, "t", "at least 2 samples", len(self))
        return float(np.median(np.diff(self.t)))

    def has(self, channel: str) -> bool:
        """Whether the channel is present."""
        return channel in self.channels

    def need(self, channel: str, why: str) -> Array:
        """Samples (N,) of a channel; `MissingChannel` (exit status 4) when it is absent.

        `why` completes "channel 'x' is needed ...", for instance "to predict the force".
        """
        if channel not in self.channels:
            present, where = tuple(self.channels), self.source or self.name
            raise MissingChannel(where, channel, why, present, self.cure)
        return self.channels[channel]

    @property
    def cure(self) -> str:
        """What mends a wrong column of the file that it was read from; '' where there is no file."""
        return cure(self.file) if self.file else ""

    def slice(self, i: int, j: int | None) -> Record:
        """Samples i to j (Python slice rules); the time axis keeps its values."""
        part = {name: samples[i:j] for name, samples in self.channels.items()}
        wild = self.wild and {name: mask[i:j] for name, mask in self.wild.items()}
        return replace(self, t=self.t[i:j], channels=part, wild=wild)

    def bridged(self, channel: str) -> Array:
        """Samples (N,) of a channel it has, with straight lines in the place of wild ones."""
        y, mask = self.channels[channel], (self.wild or {}).get(channel)
        if mask is None or not mask.any() or mask.all():
            return y
        return _frozen(np.interp(self.t, self.t[~mask], y[~mask]))

    def noted(self, *sentences: str) -> Record:
        """The same data with further notes."""
        return replace(self, notes=self.notes + sentences)


def _frozen(samples: npt.ArrayLike) -> Array:
    """Read-only float64 copy; a view is taken when the array is already one."""
    array = np.asarray(samples, dtype=np.float64)
    if array.flags.writeable:
        array = array.copy()
        array.flags.writeable = False
    return array

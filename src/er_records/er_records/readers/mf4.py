"""ASAM MDF (`.mf4`): channels named as in the contract or by a mapping.

The unit stored with a channel is converted. The time axis is that of the deflection (else of the
first contract channel); channels on other axes are brought to it, which is noted.
"""

from __future__ import annotations

import gc
import sys
from collections.abc import Callable, Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from er_common.extras import extra
from er_models.errors import ErError, InputError

from er_records.provenance import digest_bytes
from er_records.readers.columns import Column
from er_records.readers.table import Numbers, Table
from er_records.record import CHANNELS, Array

if TYPE_CHECKING:
    from asammdf import MDF

T = TypeVar("T")
MAGIC = b"MDF     4"


def table(path: Path) -> Table:
    """The channels of an MDF 4 file.

    Raises:
        InputError: Damaged file, no channel; where they are read, a name that occurs twice, no numbers.
    """
    data = path.read_bytes()
    if not data.startswith(MAGIC):
        raise InputError(
            path, "", f"an MDF 4 file (beginning with '{MAGIC.decode()}')", "other data"
        )
    with extra("er_records[mf4]", f"{path}: MF4"):
        import asammdf  # noqa: F401
    own = _within(path, data, _channels)
    if not own:
        raise InputError(path, "channels", f"at least one of {', '.join(CHANNELS)}", "none")
    header = tuple(f"{name} [{unit}]" if unit else name for name, unit in own)
    signals: dict[int, tuple[Array, Array]] = {}

    def numbers(columns: Sequence[Column]) -> Numbers:
        wanted = {c.index: own[c.index][0] for c in columns}
        signals.update(
            _within(path, data, lambda mdf: {i: _signal(path, mdf, n) for i, n in wanted.items()})
        )
        bare = [c.name for c in columns if not c.stated]
        notes = [f"{name} carries no unit, taken as SI" for name in bare]
        return [signals[c.index][1] for c in columns], notes

    digest = digest_bytes(data)
    return Table(path, header, numbers, digest, times=lambda index: signals[index][0])


def _within(path: Path, data: bytes, work: Callable[[MDF], T]) -> T:
    """What some work finds in an opened file; `InputError` where the file is damaged."""
    from asammdf import MDF

    hook, failure = sys.unraisablehook, ""
    # a half-read file object complains once more when it is destroyed: one message is enough
    sys.unraisablehook = lambda _: None
    try:
        with MDF(BytesIO(data)) as mdf:
            return work(mdf)
    except ErError:
        raise
    except Exception as error:  # damaged blocks raise whatever their bytes provoke
        failure = (str(error).splitlines() or [type(error).__name__])[0]
    finally:
        if failure:
            gc.collect()
        sys.unraisablehook = hook
    raise InputError(path, "", "a whole MDF 4 file", f"a damaged one ({failure})")


def _channels(mdf: MDF) -> list[tuple[str, str]]:
    """Name and unit of every channel that is no time axis; no unit where a name occurs twice."""
    names = [name for name in mdf.channels_db if not _is_time(mdf, name)]
    return [(name, _unit(mdf, name)) for name in names]


def _unit(mdf: MDF, name: str) -> str:
    """Unit of a channel; '' where there is none or the name occurs twice."""
    places = mdf.whereis(name)
    if len(places) > 1:
        return ""
    group, index = places[0]
    return str(mdf.get_channel_unit(group=group, index=index)).strip()


def _is_time(mdf: MDF, name: str) -> bool:
    """Whether all channels of that name are time axes."""
    return all(mdf.masters_db.get(group) == index for group, index in mdf.channels_db[name])


def _signal(path: Path, mdf: MDF, name: str) -> tuple[Array, Array]:
    """Times (n,) [s] and samples (n,) of a channel as stored; samples marked invalid become NaN."""
    places = mdf.whereis(name)
    if len(places) > 1:
        raise InputError(path, f"channel '{name}'", "one channel of that name", f"{len(places)}")
    group, index = places[0]
    signal = mdf.get(group=group, index=index, ignore_invalidation_bits=True)
    raw = np.asarray(signal.samples)
    if raw.dtype.kind not in "iuf" or raw.ndim != 1:
        raise InputError(path, f"channel '{name}'", "numbers", f"samples of type {raw.dtype}")
    samples = raw.astype(np.float64)
    if signal.invalidation_bits is not None:
        samples[np.asarray(signal.invalidation_bits, dtype=bool)] = np.nan
    return np.asarray(signal.timestamps, dtype=np.float64), samples

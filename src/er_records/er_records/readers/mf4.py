"""ASAM MDF (`.mf4`): channels named as in the contract or by a names file.

The unit stored with a channel is converted. The time axis is that of the deflection (else of the
first contract channel); channels on other axes are brought to it, which is noted.
"""

from __future__ import annotations

import gc
import sys
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from er_common.extras import extra
from er_models.errors import ErError, InputError

from er_records.provenance import digest_bytes
from er_records.readers.columns import Column, resolve, split_header, to_si
from er_records.record import CHANNELS, HELD, Array, Record, unit_of
from er_records.sampling import at

if TYPE_CHECKING:
    from asammdf import MDF

MAGIC = b"MDF     4"

BASE = ("deflection", *(name for name in CHANNELS if name not in ("deflection", "temperature")))
"""Whose time axis the record takes: the first of these that is there."""


def read(path: Path, names: Mapping[str, str] | None = None) -> list[Record]:
    """The one record of an MDF 4 file.

    Args:
        path: File.
        names: Contract name to channel name, for files with other names.

    Raises:
        InputError: Damaged file, no channel of the contract, a name that occurs twice.
    """
    data = path.read_bytes()
    if not data.startswith(MAGIC):
        raise InputError(
            path, "", f"an MDF 4 file (beginning with '{MAGIC.decode()}')", "other data"
        )
    signals, notes, failure = _signals(path, data, names or {})
    if failure:
        raise InputError(path, "", "a whole MDF 4 file", f"a damaged one ({failure})")
    base = next((name for name in BASE if name in signals), next(iter(signals)))
    t = signals[base][0]
    channels = {}
    for name, (own_t, samples) in signals.items():
        same = own_t.size == t.size and bool(np.array_equal(own_t, t))
        channels[name] = samples if same else _onto(own_t, samples, t, name)
        if not same:
            notes.append(f"{name} is sampled at other times and was brought to those of {base}")
    return [Record(path.stem, t, channels, tuple(notes), True, str(path), digest_bytes(data))]


def _signals(
    path: Path, data: bytes, names: Mapping[str, str]
) -> tuple[dict[str, tuple[Array, Array]], list[str], str]:
    """Times and samples by channel, notes, and why the file cannot be read ('' if it can)."""
    with extra("er_records[mf4]", f"{path}: MF4"):
        from asammdf import MDF

    hook = sys.unraisablehook
    # a half-read file object complains once more when it is destroyed: one message is enough
    sys.unraisablehook = lambda _: None
    failure = ""
    try:
        with MDF(BytesIO(data)) as mdf:
            columns, own, notes = _columns(path, mdf, names)
            signals = {c.name: _signal(path, mdf, c, own[c.index], notes) for c in columns}
            return signals, notes, ""
    except ErError:
        raise
    except Exception as error:  # damaged blocks raise whatever their bytes provoke
        failure = (str(error).splitlines() or [type(error).__name__])[0]
    finally:
        if failure:
            gc.collect()
        sys.unraisablehook = hook
    return {}, [], failure


def _columns(
    path: Path, mdf: MDF, names: Mapping[str, str]
) -> tuple[list[Column], list[str], list[str]]:
    """Channels to read, the file's own name of every channel, and notes."""
    wanted = {*CHANNELS, *names.values(), *(split_header(value)[0] for value in names.values())}
    own = [name for name in mdf.channels_db if not _is_time(mdf, name)]
    extra_one = {name for name in own if unit_of(name) and len(mdf.whereis(name)) == 1}
    header = [_header(path, mdf, n) if n in wanted | extra_one else n for n in own]
    if not own:
        raise InputError(path, "channels", f"at least one of {', '.join(CHANNELS)}", "none")
    columns, ignored = resolve(path, header, names, needs_time=False)
    notes = [f"{len(ignored)} other channels were left out"] if ignored else []
    return columns, own, notes


def _is_time(mdf: MDF, name: str) -> bool:
    """Whether all channels of that name are time axes."""
    return all(mdf.masters_db.get(group) == index for group, index in mdf.channels_db[name])


def _header(path: Path, mdf: MDF, name: str) -> str:
    """The channel as a header cell: its name, with its unit in brackets when it has one."""
    places = mdf.whereis(name)
    if len(places) > 1:
        raise InputError(path, f"channel '{name}'", "one channel of that name", f"{len(places)}")
    group, index = places[0]
    unit = mdf.get_channel_unit(group=group, index=index).strip()
    return f"{name} [{unit}]" if unit else name


def _signal(
    path: Path, mdf: MDF, column: Column, name: str, notes: list[str]
) -> tuple[Array, Array]:
    """Times (N,) [s] and samples (N,) [SI] of a channel; samples marked invalid become NaN."""
    group, index = mdf.whereis(name)[0]
    signal = mdf.get(group=group, index=index, ignore_invalidation_bits=True)
    raw = np.asarray(signal.samples)
    if raw.dtype.kind not in "iuf" or raw.ndim != 1:
        raise InputError(path, f"channel '{name}'", "numbers", f"samples of type {raw.dtype}")
    samples = raw.astype(np.float64)
    if signal.invalidation_bits is not None:
        samples[np.asarray(signal.invalidation_bits, dtype=bool)] = np.nan
    samples, how = to_si(column, samples)
    notes += (
        how if how else [] if column.stated else [f"{column.name} carries no unit, taken as SI"]
    )
    return np.asarray(signal.timestamps, dtype=np.float64), samples


def _onto(own_t: Array, samples: Array, t: Array, name: str) -> Array:
    """Samples at times t, NaN outside the channel's own time span."""
    if own_t.size == 0:
        return np.full(t.size, np.nan)
    # a held value stays in force for one more period
    after = float(np.median(np.diff(own_t))) if name in HELD and own_t.size > 1 else 0.0
    inside = (t >= own_t[0] - 1e-9) & (t <= own_t[-1] + after + 1e-9)
    return np.asarray(np.where(inside, at(own_t, samples, t, name), np.nan))

"""TDMS, what LabVIEW and DIAdem write: a channel each with its unit and, of a waveform, its own times."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from er_common.extras import extra
from er_models.errors import InputError

from er_records.provenance import digest_bytes
from er_records.readers.columns import Column
from er_records.readers.table import Numbers, Table
from er_records.record import CHANNELS, Array

UNIT_KEYS = ("unit_string", "NI_UnitDescription", "unit")
"""Properties that hold the unit of a channel, as DIAdem and LabVIEW call them."""


def table(path: Path) -> Table:
    """The channels of a TDMS file, `group/channel` where several groups have one of that name.

    Raises:
        InputError: A damaged file, or one without numbers.
    """
    data = path.read_bytes()
    with extra("er_records[tdms]", f"{path}: TDMS"):
        from nptdms import TdmsFile
    try:
        file = TdmsFile.read(BytesIO(data))
        channels = [c for g in file.groups() for c in g.channels() if _is_numeric(c)]
        found = [(c, np.asarray(c[:], dtype=np.float64)) for c in channels]
    except Exception as error:  # damaged files raise whatever their bytes provoke
        why = (str(error).splitlines() or [type(error).__name__])[0]
        raise InputError(path, "", "a TDMS file", why) from None
    if not found:
        raise InputError(path, "channels", f"at least one of {', '.join(CHANNELS)}", "none")
    names = [c.name for c, _ in found]
    header = tuple(
        _header(c, c.name if names.count(c.name) == 1 else f"{c.group_name}/{c.name}")
        for c, _ in found
    )
    waveforms = any(_step(c) for c, _ in found)

    def numbers(columns: Sequence[Column]) -> Numbers:
        return [found[c.index][1] for c in columns], []

    def times(index: int) -> Array:
        channel, samples = found[index]
        start = float(channel.properties.get("wf_start_offset", 0.0))
        step = _step(channel)
        return np.asarray(start + step * np.arange(samples.size)) if step else np.empty(0)

    own = times if waveforms else None
    return Table(path, header, numbers, digest_bytes(data), times=own)


def _is_numeric(channel: Any) -> bool:
    """Whether a channel holds numbers."""
    return len(channel) > 0 and np.asarray(channel[:1]).dtype.kind in "iuf"


def _step(channel: Any) -> float:
    """Sample time of a waveform [s]; 0 where the channel is none."""
    return float(channel.properties.get("wf_increment", 0.0))


def _header(channel: Any, name: str) -> str:
    """The channel as a header cell."""
    stated = (str(channel.properties.get(key, "")).strip() for key in UNIT_KEYS)
    unit = next((text for text in stated if text), "")
    return f"{name} [{unit}]" if unit else name

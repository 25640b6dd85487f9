"""Findings of the preflight, told together where they are alike."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def grouped(findings: list[Mapping[str, Any]]) -> list[tuple[Mapping[str, Any], list[str]]]:
    """The first finding of each kind and channel, with the names of all records that have it."""
    groups: dict[tuple[str, ...], tuple[Mapping[str, Any], list[str]]] = {}
    for f in findings:
        key = (f["check"], f["level"], f["channel"], f["expected"])
        groups.setdefault(key, (f, []))[1].append(f["record"])
    return list(groups.values())


def place_of(f: Mapping[str, Any], records: list[str]) -> str:
    """Channel and record of a finding, or how many records."""
    where = records[0] if len(records) == 1 else f"{len(records)} records"
    return f"{f['channel']} ({where})" if f["channel"] else where

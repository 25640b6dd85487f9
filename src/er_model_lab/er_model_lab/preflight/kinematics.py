"""Units, signs, clocks and offsets of the motion channels, from what each must be of the others."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from er_records.record import CHANNELS, Array, Record

from er_model_lab.motion.white_noise import white_noise
from er_model_lab.preflight.derivative import Relation, relate
from er_model_lab.preflight.finding import Finding, Level
from er_models import constants

LENGTHS: dict[str, float] = {"mm": 1e3, "cm": 1e2, "inches": 1.0 / 0.0254, "feet": 1.0 / 0.3048}
"""Units a length may come in, and how many of them are a metre."""
TOLERANCE = 0.06
"""Share by which a factor may be off and still be recognised."""
CONTRADICTION = 0.5
"""Deviation of a factor from 1 that no unit explains and no sensor has."""
NOTABLE = 0.02
"""Deviation of a factor from 1 that is worth a word."""
UNRESOLVED = 0.15
"""Deviation up to which an acceleration may differ because it jumps between two samples."""
FASTER = "accelerations that jump between samples do this, too; record faster to tell"
LATE = 0.25
"""Delay between two channels that is worth a word, in samples."""
AGAINST = -0.3
"""Correlation of force and velocity below which the sign of one of them is wrong."""
OWN = 0.2
"""Share of an actuator's force that the motion does not tell, from which on its sign can be."""

TURNED = "turned"
ACCELERATION = "sprung_acceleration less unsprung_acceleration"
ORDERS: dict[str, int] = {"deflection": 0, "deflection_velocity": 1, ACCELERATION: 2}
"""How often each is a derivative of the deflection."""


@dataclass(frozen=True)
class Pair:
    """One channel as the derivative of another."""

    of: str
    is_: str
    relation: Relation


def measured(record: Record) -> dict[str, Array]:
    """The motion channels a record measured (not derived), the accelerations as their difference."""
    found = {
        name: record.channels[name]
        for name in ("deflection", "deflection_velocity")
        if record.has(name) and name not in record.derived
    }
    if record.has("sprung_acceleration") and record.has("unsprung_acceleration"):
        found[ACCELERATION] = (
            record.channels["sprung_acceleration"] - record.channels["unsprung_acceleration"]
        )
    return found


def parted(record: Record) -> Array | None:
    """What a deflection does from each sample to the next beyond what its measured velocity says (n - 1,) [m].

    None where one of both was not measured.
    """
    have = measured(record)
    if "deflection" not in have or "deflection_velocity" not in have:
        return None
    v = have["deflection_velocity"]
    return np.asarray(np.diff(have["deflection"]) - 0.5 * record.dt * (v[1:] + v[:-1]))


def pairs(record: Record) -> list[Pair]:
    """What each pair of motion channels says; pairs without anything in common are left out."""
    found = []
    for (a, y), (b, z) in itertools.combinations(measured(record).items(), 2):
        relation = relate(y, z, ORDERS[b] - ORDERS[a], record.dt)
        if relation is not None:
            found.append(Pair(a, b, relation))
    return found


def unit_findings(record: Record, known: list[Pair]) -> Iterator[Finding]:
    """Wrong units and signs, the channel named; else factors that no unit explains."""
    guess = explained({(p.of, p.is_): p.relation.gain for p in known})
    if not guess:
        off = [
            p for p in known if abs(p.relation.gain - 1.0) > max(NOTABLE, 4.0 * p.relation.gain_sd)
        ]
        found = [_gain(record, p, channel) for p, channel in blamed(off, _misfit)]
        yield from found
        if all(f.level != "fail" for f in found):
            yield from offset_findings(record)
    names = {p.of for p in known} | {p.is_ for p in known}
    for channel, unit in guess.items():
        si = CHANNELS.get(channel, "m/s2")
        others = " and ".join(sorted(names - {channel}, key=len))
        if unit == TURNED:
            yield _finding(
                record, "units", "fail", channel, "extension positive",
                f"a channel with the opposite sign of {others}", f"multiply {channel} by -1",
            )  # fmt: skip
        else:
            yield _finding(
                record, "units", "fail", channel, si,
                f"a channel that looks like {_written(si, unit)} beside {others}", f"convert {channel} to {si}",
            )  # fmt: skip


def unchecked_findings(record: Record, known: list[Pair]) -> Iterator[Finding]:
    """Channels of the motion that have nothing in common with another one, though there is one."""
    have = measured(record)
    alone = [n for n in have if not any(n in (p.of, p.is_) for p in known)]
    if len(have) > 1 and alone:
        yield _finding(
            record, "units", "warning", alone[0] if len(alone) == 1 else "", "channels that show the same motion",
            f"{' and '.join(alone)}: nothing in common with another one, so that unit and sign stay unchecked",
            "check unit and sign by hand, or record a motion well above the noise",
        )  # fmt: skip


def blamed(off: list[Pair], size: Callable[[Pair], float]) -> list[tuple[Pair, str]]:
    """Pairs that do not fit, each with the channel to blame; small misfits beside large ones are left aside.

    Where all of them share one channel it is that channel, once; else the derivative of each.
    """
    most = max((size(p) for p in off), default=0.0)
    off = [p for p in off if size(p) > 0.3 * most]
    shared = set.intersection(*({p.of, p.is_} for p in off)) if len(off) > 1 else set()
    if not shared:
        return [(p, p.is_) for p in off]
    return [(off[0], shared.pop())]


def _misfit(p: Pair) -> float:
    """How far a factor is from 1."""
    return float(abs(np.log(max(abs(p.relation.gain), 1e-12))))


def _written(si: str, unit: str) -> str:
    """A unit of length in place of the metre: mm in m/s2 is mm/s2."""
    return unit if unit == "g" else si.replace("m", unit, 1)


def _gain(record: Record, p: Pair, channel: str) -> Finding:
    """A factor between two channels that no unit explains."""
    g, sd = p.relation.gain, p.relation.gain_sd
    fails = abs(g - 1.0) > CONTRADICTION
    nth = "derivative" if ORDERS[p.is_] - ORDERS[p.of] == 1 else "second derivative"
    expected = f"the {nth} of {p.of}" if channel == p.is_ else f"a channel whose {nth} is {p.is_}"
    if channel == p.of:
        g, sd = 1.0 / g, sd / g**2
    level: Level = "fail" if fails else "warning"
    remedy = "check the calibration of both sensors and the geometry of their mounts"
    if channel == ACCELERATION and abs(g - 1.0) < UNRESOLVED:
        level, remedy = "note", FASTER
    return _finding(
        record, "units", level, channel, expected, f"{g:.3g} +- {sd:.1g} times that", remedy
    )  # fmt: skip


def explained(gains: Mapping[tuple[str, str], float]) -> dict[str, str]:
    """Channel to unit (or sign) of the fewest mistakes that explain all factors; empty when there is none or none do.

    gains: (channel, its derivative) to the factor between them, 1 where both are SI.
    """
    names = sorted({n for pair in gains for n in pair}, key=lambda n: ORDERS[n])
    units = {n: [("", 1.0), *_units(n), (TURNED, -1.0)] for n in names}
    found: list[tuple[int, dict[str, str]]] = []
    for choice in itertools.product(*units.values()):
        factor = dict(zip(names, (f for _, f in choice), strict=True))
        if all(_near(g, factor[b] / factor[a]) for (a, b), g in gains.items()):
            wrong = {n: u for n, (u, _) in zip(names, choice, strict=True) if u}
            found.append((len(wrong), wrong))
    count, wrong = min(found, key=lambda f: f[0], default=(0, {}))
    # factors that need every channel to be wrong are no units
    return wrong if count < len(names) else {}


def _units(name: str) -> list[tuple[str, float]]:
    """Units a channel may come in, and how many of them are one of SI."""
    lengths = list(LENGTHS.items())
    return [*lengths, ("g", 1.0 / constants.g)] if name == ACCELERATION else lengths


def _near(found: float, expected: float) -> bool:
    """Whether a factor is the expected one, within what a sensor's gain may be off."""
    return bool(found / expected > 0.0 and abs(np.log(found / expected)) < TOLERANCE)


def clock_findings(record: Record, known: list[Pair]) -> Iterator[Finding]:
    """Delays between the motion channels."""
    late = [
        p
        for p in known
        if abs(p.relation.delay) > max(LATE * p.relation.dt, 4.0 * p.relation.delay_sd)
    ]
    for p, channel in blamed(late, lambda p: abs(p.relation.delay)):
        delay, sd = p.relation.delay, p.relation.delay_sd
        delay = delay if channel == p.is_ else -delay
        side = "after" if delay > 0 else "before"
        other = p.of if channel == p.is_ else p.is_
        unresolved = channel == ACCELERATION and abs(delay) < 0.5 * record.dt
        remedy = "look for a filter or another clock; a lag of the velocity channel is found as velocity_lag"
        yield _finding(
            record, "clock", "note" if unresolved else "warning", channel, f"the clock of {other}",
            f"{1e3 * abs(delay):.2f} +- {1e3 * sd:.1g} ms {side} it", FASTER if unresolved else remedy,
        )  # fmt: skip


def gravity_findings(record: Record) -> Iterator[Finding]:
    """Gravity left in an accelerometer."""
    for name in ("sprung_acceleration", "unsprung_acceleration"):
        if record.has(name) and 0.5 < abs(float(record.channels[name].mean())) / constants.g < 1.5:
            yield _finding(
                record, "bias", "fail", name, "gravity removed",
                f"a mean of {float(record.channels[name].mean()):.4g} m/s2", f"take gravity off {name}",
            )  # fmt: skip


def offset_findings(record: Record) -> Iterator[Finding]:
    """A velocity channel that does not add up to the deflection."""
    apart = parted(record)
    if apart is None:
        return
    x, v = (record.channels[name] for name in ("deflection", "deflection_velocity"))
    seconds = (len(record) - 1) * record.dt
    offset = -float(np.mean(apart)) / record.dt
    moving = float(np.sqrt(np.mean((v - v.mean()) ** 2)))
    sd = white_noise([v]) / np.sqrt(len(record)) + np.sqrt(2.0) * _small(x) / seconds
    if abs(offset) > max(6.0 * sd, 2e-3 * moving):
        yield _finding(
            record, "bias", "warning", "deflection_velocity", "zero at standstill",
            f"{1e3 * offset:.3g} mm/s more than the deflection moves",
            "zero the sensor; the force of the field turns within a few mm/s",
        )  # fmt: skip


def _small(x: Array) -> float:
    """Noise of the ends of a deflection, not less than its resolution."""
    return white_noise([x]) + 1e-9


def power_findings(record: Record) -> Iterator[Finding]:
    """A damper takes power out of the motion: force and velocity that say otherwise have a wrong sign."""
    if not (record.has("damper_force") and record.has("deflection_velocity")):
        return
    f, v = record.channels["damper_force"], record.channels["deflection_velocity"]
    f, v = f - f.mean(), v - v.mean()
    size = float(np.sqrt(np.mean(f**2) * np.mean(v**2)))
    if size > 0.0 and float(np.mean(f * v)) / size < AGAINST:
        yield _finding(
            record, "power", "fail", "damper_force", "a force that resists extension to be positive",
            f"a correlation of {float(np.mean(f * v)) / size:.2f} with the velocity: it would drive the motion",
            "turn the sign of the force, or that of the deflection and its velocity",
        )  # fmt: skip


def actuator_findings(record: Record) -> Iterator[Finding]:
    """An actuator that resists extension draws the body down: one that lifts it, beside spring and damper, is turned.

    Of its force counts what neither deflection nor velocity tells: a controller may make it from these.
    """
    needed = ("actuator_force", "sprung_acceleration", "deflection", "deflection_velocity")
    if not all(record.has(c) for c in needed) or "sprung_acceleration" in record.derived:
        return
    force, lift, x, v = (record.channels[c] for c in needed)
    beside = np.stack([np.ones(x.size), x, v], axis=1)
    own, left = (y - beside @ np.linalg.lstsq(beside, y, rcond=None)[0] for y in (force, lift))
    if not np.std(own) > OWN * np.std(force):
        return
    together = float(np.mean(own * left) / (np.std(own) * np.std(left) + 1e-300))
    if together > -AGAINST:
        yield _finding(
            record, "power", "fail", "actuator_force", "a force that resists extension to be positive",
            f"one that lifts the body: a correlation of {together:.2f} with its acceleration",
            "multiply it by -1 (`sign: -1` in names.yaml)",
        )  # fmt: skip


def road_findings(record: Record) -> Iterator[Finding]:
    """The road beside the acceleration of the wheel, which follows it at low frequencies."""
    if not (record.has("road") and record.has("unsprung_acceleration")):
        return
    relation = relate(
        record.channels["road"], record.channels["unsprung_acceleration"], 2, record.dt, 4.0
    )
    if relation is None or 0.1 < abs(relation.gain) < 10.0:
        return
    near = [u for u, f in LENGTHS.items() if 0.4 < abs(relation.gain) * f < 2.5]
    yield _finding(
        record, "units", "fail", "road", "m",
        f"a road of which the wheel follows {abs(relation.gain):.3g}" + (f": looks like {near[0]}" if near else ""),
        "convert the road to m",
    )  # fmt: skip


def fine(record: Record, known: list[Pair]) -> Iterator[Finding]:
    """Pairs of channels that agree, with factor and delay."""
    if not known:
        name = next(iter(measured(record)), "none")
        words = f"motion measured by {name}: nothing to compare it with"
        yield Finding("units", "note", record.name, "", "two channels of the motion", words)
    for p in known:
        g, late = p.relation, 1e3 * p.relation.delay
        words = f"{g.gain:.3f} +- {g.gain_sd:.1g} times what {p.of} says, {late:+.2f} +- {1e3 * g.delay_sd:.1g} ms"
        yield Finding("units", "ok", record.name, p.is_, f"the derivative of {p.of}", words)


def _finding(
    record: Record, check: str, level: Level, channel: str, expected: str, found: str, remedy: str
) -> Finding:
    """A finding of this record."""
    return Finding(
        check, level, record.name, channel, expected, found, remedy, record.source or record.name
    )

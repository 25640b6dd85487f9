"""Messages of any content, types kept, at every input of a node's core: what goes out must be possible."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence
from random import Random
from typing import Any

from builtin_interfaces.msg import Time
from er_common.stamps import StampLimits
from er_ros_common.clock import LAST_SECOND, from_stamp, to_stamp
from er_ros_common.core import When

from er_common import topics
from er_ros_common import builders
from test.reliability.bus import NAMES, SECOND, STEADY, SYSTEM, Bus, core

NUMBERS = (
    0.0,
    -0.0,
    1.0,
    -1.0,
    math.nan,
    math.inf,
    -math.inf,
    1e308,
    -1e308,
    5e-324,
    1e30,
    1e-30,
    1e6,
)
SECONDS = (-(2**31), -5, -1, 0, 1, LAST_SECOND)
NANOSECONDS = (0, 1, SECOND - 1, SECOND, 2**32 - 1)
"""What a stamp can hold, whether it is a time or not."""
AHEAD = round(StampLimits().future * SECOND)
LARGEST_FORCE = 1e5
"""No damper of a car makes more [N]."""


STRETCH = 200
"""Ticks of mostly believable messages, then as many of mostly unbelievable ones, and so on."""


def fuzz(name: str, count: int, seed: int, *, aged: bool = True) -> list[str]:
    """What was impossible in the answers of a core to this many messages; it stops at ten.

    aged: whether a clock tells the age of stamps. Then nothing may be said with a stamp that it never had.
    """
    each, random = core(name), Random(seed)
    state, wrong = each.start(), []
    for k, topic, message, now in messages(each.inputs, count, random):
        try:
            when = When(STEADY + now, SYSTEM + now if aged else None)
            state, said = each.on_message(state, topic, message, when)
            if random.random() < 0.3:
                state, more = each.on_time(state, when)
                said = [*said, *more]
            builders.node_status(builders.Tick(1, 1), name, "running", stamps=state.stamps)
        except Exception as error:
            wrong.append(f"{name} message {k}: {type(error).__name__}: {error}")
            state, said = each.start(), []
        for _, answer in said:
            wrong += [f"{name} message {k}: {bad}" for bad in impossible(answer)]
            if aged and not 0 < from_stamp(answer.header.stamp) - SYSTEM <= now + AHEAD:
                wrong.append(f"{name} message {k}: stamp is {answer.header.stamp}")
        if len(wrong) >= 10:
            break
    return wrong


def messages(
    inputs: Sequence[topics.Topic], count: int, random: Random
) -> Iterator[tuple[int, topics.Topic, Any, int]]:
    """Number, topic, message and time [ns since the start] of this many messages, some lost, some twice."""
    k = seq = now = 0
    while k < count:
        seq += 1
        now += random.choice((5,) * 60 + (0, 1, 10, 60)) * 1_000_000
        wild = 0.02 if seq // STRETCH % 2 else 0.5
        for topic in random.sample(inputs, len(inputs)):
            for _ in range(random.choice((1,) * 30 + (0, 2))):
                k += 1
                yield k, topic, _message(topic, random, now, seq, wild), now


def fuzz_plant(count: int, seed: int) -> list[str]:
    """What was impossible in the duties that the plant applies after this many commands of any content."""
    bus, random = Bus((), seed=1), Random(seed)
    gate = bus.rig.gate
    wrong = []
    for k, _, message, _ in messages((topics.PWM_COMMAND,), count, random):
        try:
            bus.command(message)
            bus.tick()
        except Exception as error:
            wrong.append(f"plant message {k}: {type(error).__name__}: {error}")
        applied = bus.log[topics.PWM_APPLIED.name].pop().message
        wrong += [f"plant message {k}: {bad}" for bad in impossible(applied)]
        if not gate.duty_min <= applied.duty <= gate.duty_max:
            wrong.append(f"plant message {k}: duty is {applied.duty}")
        for log in bus.log.values():
            log.clear()
        if len(wrong) >= 10:
            break
    return wrong


def impossible(answer: Any) -> list[str]:
    """Numbers of a message that are not finite, or outside what there can be."""
    found = []
    for field, kind in answer.get_fields_and_field_types().items():
        value = getattr(answer, field)
        if kind == "double" and not math.isfinite(value):
            found.append(f"{field} is {value}")
    duty, force = getattr(answer, "duty", 0.0), getattr(answer, "force", 0.0)
    if not 0.0 <= duty <= 1.0:
        found.append(f"duty is {duty}")
    if abs(force) > LARGEST_FORCE:
        found.append(f"force is {force}")
    return found


def _message(topic: topics.Topic, random: Random, now: int, seq: int, wild: float) -> Any:
    """A message with any numbers where it is wild, with this probability; others move as a car does."""
    message = topic.type()
    spoilt = random.random() < wild
    for field, kind in message.get_fields_and_field_types().items():
        if kind == "double":
            number = (
                random.choice(NUMBERS)
                if spoilt and random.random() < 0.5
                else _usual(field, random)
            )
            setattr(message, field, float(number))
        elif kind == "boolean":
            setattr(message, field, not spoilt or random.random() < 0.7)
        elif kind == "uint8" and spoilt:
            setattr(message, field, random.choice((0, 1, 2, 5, 6, 255)))
        elif kind == "uint64":
            setattr(message, field, random.choice((seq, 0, 2**64 - 1)) if spoilt else seq)
    wrong = random.choice((0, 0, 0, SECOND, -SECOND, 3600 * SECOND)) if spoilt else 0
    message.header.stamp = to_stamp(SYSTEM + now + wrong)
    if spoilt and random.random() < 0.2:
        message.header.stamp = Time(sec=random.choice(SECONDS), nanosec=random.choice(NANOSECONDS))
    return message


def _usual(field: str, random: Random) -> float:
    """A number that such a field may have."""
    if field in ("duty", "f1", "f2", "f3", "certainty"):
        return random.random()
    return random.gauss(0.0, {"deflection": 0.003, "velocity": 0.1}.get(field, 1.0))


def run(count: int) -> int:
    """Fuzz every core with its share of the messages, a fifth without ages; 1 where anything impossible came out."""
    names = (*NAMES, "fault_estimator", "skyhook_controller", "ftc_controller", "plant")
    wrong = []
    for seed, name in enumerate(names):
        share = count // len(names)
        if name == "plant":
            found = fuzz_plant(share, seed)
        else:
            old = share // 5
            found = fuzz(name, share - old, seed) + fuzz(name, old, seed, aged=False)
        sys.stdout.write(
            f"{name}: {count // len(names)} messages, {len(found)} impossible answers\n"
        )
        wrong += found
    for line in wrong:
        sys.stdout.write(f"{line}\n")
    return int(bool(wrong))

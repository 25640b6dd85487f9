"""Messages of any content, types kept, at every input of a node's core: what goes out must be possible."""

from __future__ import annotations

import math
import sys
from random import Random
from typing import Any

from er_ros_common.clock import to_stamp
from er_ros_common.core import When

from er_ros_common import topics
from test.reliability.bus import NAMES, SECOND, STEADY, SYSTEM, core

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
LARGEST_FORCE = 1e5
"""No damper of a car makes more [N]."""


def fuzz(name: str, count: int, seed: int) -> list[str]:
    """What was impossible in the answers of a core to this many messages; it stops at ten."""
    each, random = core(name), Random(seed)
    state, now, wrong = each.start(), 0, []
    for k in range(1, count + 1):
        now += random.choice((0, 1, 5, 5, 5, 5, 60)) * 1_000_000
        topic = random.choice(each.inputs)
        message = _message(topic, random, now, k)
        try:
            state, said = each.on_message(state, topic, message, _when(now))
            if random.random() < 0.3:
                state, more = each.on_time(state, _when(now))
                said = [*said, *more]
        except Exception as error:
            wrong.append(f"{name} message {k}: {type(error).__name__}: {error}")
            state = each.start()
            said = []
        wrong += [f"{name} message {k}: {bad}" for _, answer in said for bad in impossible(answer)]
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


def _when(now: int) -> When:
    return When(STEADY + now, SYSTEM + now)


def _message(topic: topics.Topic, random: Random, now: int, seq: int) -> Any:
    """A message with any numbers, mostly with a stamp that is believed."""
    message = topic.type()
    wild = random.random() < 0.5
    for field, kind in message.get_fields_and_field_types().items():
        if kind == "double":
            number = (
                random.choice(NUMBERS)
                if wild and random.random() < 0.5
                else random.gauss(0.0, 1.0)
            )
            setattr(message, field, float(number))
        elif kind == "boolean":
            setattr(message, field, random.random() < 0.9)
        elif kind == "uint8":
            setattr(message, field, random.choice((0, 0, 0, 1, 2, 5, 6, 255)))
        elif kind == "uint64":
            setattr(message, field, random.choice((seq, seq, seq, 0, 2**64 - 1)))
    # halves of a sample share a stamp, as those of one tick do
    tick = 5_000_000 * (now // 5_000_000)
    stamp = SYSTEM + tick + random.choice((0,) * 16 + (SECOND, -SECOND, 3600 * SECOND))
    message.header.stamp = to_stamp(0 if random.random() < 0.02 else stamp)
    return message


def run(count: int) -> int:
    """Fuzz every core with its share of the messages; 1 where anything impossible came out."""
    names = (*NAMES, "skyhook_controller", "ftc_controller")
    wrong = []
    for seed, name in enumerate(names):
        found = fuzz(name, count // len(names), seed)
        sys.stdout.write(
            f"{name}: {count // len(names)} messages, {len(found)} impossible answers\n"
        )
        wrong += found
    for line in wrong:
        sys.stdout.write(f"{line}\n")
    return int(bool(wrong))

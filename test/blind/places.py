"""Where laws act on the damper: for each place one function, composed of the laws of all truths that act there."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from test.blind.effect import Effect
from test.blind.jit import inner
from test.blind.slots import FIXED_STATES, FLD

SIGNALS = {
    "t": "t",  # time since the record began [s]
    "x": "x",  # travel of the rod [m]
    "v": "v",  # its velocity [m/s]
    "u": "total",  # duty on its way to the field, in the places `field` and `rate` alone
    "h": f"y[{FLD}]",  # duty after the chains have formed
    "f": "total",  # force that the filled damper carries, in the place `bypass` alone
    "w": "y[{state}]",  # the truth's own state
}
"""What a law may ask for by name, as it is written into the composed function."""


class Place(NamedTuple):
    """How the value of a law changes the running total, and what it is."""

    statement: str
    text: str


PLACES = {
    "field": Place("total = {law}", "maps the duty to the field, as an equivalent duty"),
    "yield_force": Place("total *= {law}", "multiplies the yield force"),
    "viscosity": Place("total *= {law}", "multiplies the viscous coefficient"),
    "fluid": Place("total += {law}", "adds to the force that the filled damper carries [N]"),
    "bypass": Place("total = {law}", "maps that force where some of the fluid goes another way"),
    "friction": Place("total += {law}", "adds to the friction of the rod [N]"),
    "elastic": Place("total += {law}", "adds to springs, gas and stops [N]"),
    "whole": Place("total *= {law}", "multiplies the whole force of the rod"),
    "rate": Place("dy[{state}] = {law}", "rate of the truth's own state"),
}


def own_states(effects: Sequence[Effect]) -> dict[str, int]:
    """Where each truth with a state of its own has it."""
    names = [effect.name for effect in effects if "rate" in effect.acts]
    return {name: FIXED_STATES + k for k, name in enumerate(names)}


def composed(place: str, effects: Sequence[Effect]) -> Callable[..., float]:
    """One compiled function `(total, t, x, v, y, dy, rows)` of all laws at a place; it returns the new total."""
    states, lines, names = own_states(effects), [], {}
    for effect in effects:
        if place in effect.acts:
            law = f"law_{effect.slot}"
            names[law] = effect.acts[place]
            state = states.get(effect.name)
            call = f"{law}({', '.join(_words(effect, place))})".format(state=state)
            lines.append(f"    {PLACES[place].statement.format(law=call, state=state)}\n")
    head = f"def {place}(total, t, x, v, y, dy, rows):\n"
    exec(compile("".join([head, *lines, "    return total\n"]), f"<{place}>", "exec"), names)
    return inner(names[place])


def _words(effect: Effect, place: str) -> Iterator[str]:
    """What is given to a law: signals by their names, and the effect's columns in order."""
    function = effect.acts[place]
    columns = iter(range(len(effect.columns)))
    for name in inspect.signature(getattr(function, "py_func", function)).parameters:
        yield SIGNALS.get(name) or f"rows[{effect.slot}, {next(columns)}]"

"""``er replay BAG``: plays a recording to the cores of its nodes and compares what they say, bit by bit.

Exit status: 0 the same, or only --values were there to be had; 1 something differs; 2 bad usage or input;
3 the recording is damaged and was played as far as it goes; 4 it lacks what a node listens to, or there was
nothing to compare. Of several recorded nodes such a one is left out, but not one that --node asked for.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from er_models.errors import InputError, MissingChannel
from er_models.files import write_whole
from er_models.one_line import OneLine, end_with
from er_ros_common.clock import from_stamp
from er_ros_common.parameter_files import read_value
from rich.console import Console
from rich.table import Table

from er_bringup.doctor import namespace
from er_bringup.played import (
    Played,
    UnknownParameters,
    assumed,
    core_of,
    namespaces_in,
    nodes_in,
    play,
)
from er_bringup.programs import CORES
from er_bringup.recording import Bag, opened

SAME, DIFFERENT, INCOMPLETE, NOTHING = 0, 1, 3, 4


def parser() -> OneLine:
    """Options of the command."""
    p = OneLine(prog="er replay", description=__doc__, allow_abbrev=False)
    p.add_argument("bag", type=Path, metavar="BAG", help="rosbag2 folder or file")
    p.add_argument(
        "--node",
        action="append",
        metavar="NODE",
        help="executable to play, again for more; by default all recorded ones",
    )
    p.add_argument(
        "--namespace", type=namespace, default="", metavar="NS", help="namespace of the corner"
    )
    p.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY:=VALUE",
        help="another value of a parameter",
    )
    p.add_argument(
        "--follow",
        action="store_true",
        help="leave out samples that the recorded node did not answer",
    )
    p.add_argument(
        "--json", metavar="FILE", help="write the result there too; - for standard output"
    )
    p.add_argument("--values", metavar="FILE", help="write every answer there, as CSV")
    return p


def given(pairs: Sequence[str]) -> dict[str, Any]:
    """Parameters KEY:=VALUE.

    Raises:
        InputError: A pair of another form, or a value that cannot be read.
    """
    found: dict[str, Any] = {}
    for pair in pairs:
        key, separator, value = pair.partition(":=")
        if not separator:
            raise InputError("--set", "", "KEY:=VALUE", f"'{pair}'")
        found[key] = read_value(value, f"--set {key}")
    return found


def replayed(options: Any) -> tuple[Bag, list[Played], dict[str, str]]:
    """Play as the options say; the recording, what its nodes said, and why others could not be played.

    Raises:
        ErError: Something of the recording or the parameters cannot be used.
    """
    bag = opened(options.bag)
    space = f"/{options.namespace.strip('/')}" if options.namespace.strip("/") else ""
    names = options.node or nodes_in(bag, space, list(CORES))
    if not names:
        raise _nothing(bag, space)
    values = given(options.set)
    made, found, left_out = [], [], {}
    for name in names:
        try:
            made.append((name, core_of(bag, name, space, values)))
        except UnknownParameters as error:
            left_out[name] = str(error)
    for name, core in made:
        if unknown := assumed(bag, name, space, values):
            _say(
                f"{name} was recorded without parameters, at their defaults: {', '.join(unknown)}"
            )
        try:
            found.append(play(bag, name, core, space, follow=options.follow))
        except MissingChannel as error:
            left_out[name] = str(error)
    return bag, found, left_out


def _say(sentence: str) -> None:
    """One line beside the result."""
    sys.stderr.write(f"er replay: {sentence}\n")


def _nothing(bag: Bag, space: str) -> InputError:
    """The error for a recording without a node that can be played, in this namespace."""
    known = ", ".join(sorted(CORES))
    expected, found = f"one of {known} in it", "none recorded"
    if spaces := namespaces_in(bag, list(CORES)):
        expected = f"--namespace with one of {', '.join(spaces)}"
        found = f"none recorded in '{space or '/'}'"
    elif not bag.parameters:
        expected = f"--node with one of {known}"
    return InputError(bag.path, "nodes", expected, found)


def incomparable(bag: Bag, found: Sequence[Played]) -> dict[str, str]:
    """Nodes that were played, but to compare with nothing, and why."""
    why = {}
    for each in (f for f in found if not f.compared):
        what = (
            f"none of its {each.recorded} recorded answers is to a sample that the replay answers"
        )
        if not each.recorded:
            what = "no answer of it is recorded"
        why[each.node] = f"{bag.path}: {each.node} is compared with nothing: {what}"
    return why


def status(
    bag: Bag, found: Sequence[Played], left_out: Iterable[str], options: argparse.Namespace
) -> int:
    """Exit status; left_out: nodes that were compared with nothing.

    Who asks for values of a node without recorded answers has what was asked for.
    """
    served = {f.node for f in found if options.values and f.answers and not f.recorded}
    missed = set(left_out) - served
    if missed and (options.node or not any(f.compared or f.node in served for f in found)):
        return NOTHING
    if bag.damage:
        return INCOMPLETE
    return DIFFERENT if any(f.different for f in found) else SAME


def document(bag: Bag, found: Sequence[Played], left_out: Mapping[str, str]) -> dict[str, object]:
    """The result for machines; left_out: nodes that were compared with nothing, and why."""
    keys = (
        "node",
        "recorded",
        "same",
        "different",
        "only_bag",
        "only_core",
        "first",
        "span",
        "skipped",
        "apart",
        "by_tick",
        "took",
        "speed",
    )
    return {
        "complete": not bag.damage,
        "damage": bag.damage,
        "left_out": dict(left_out),
        "nodes": [{k: getattr(f, k) for k in keys} | {"answers": len(f.answers)} for f in found],
    }


def values(found: Sequence[Played]) -> str:
    """Every answer as CSV: node, topic, stamp [ns], sequence number, then its fields."""
    lines = []
    for each in found:
        for topic, m in each.answers:
            fields = [
                name for name in m.get_fields_and_field_types() if name not in ("header", "seq")
            ]
            stamp = from_stamp(m.header.stamp)
            pairs = [f"{name}={getattr(m, name)!r}" for name in fields]
            lines.append(",".join([each.node, topic.name, str(stamp), str(m.seq), *pairs]))
    return "\n".join([*lines, ""])


def begun_before(found: Played) -> str:
    """Why a node with memory may differ from the first answer on; empty where the recording holds its beginning."""
    first = int(found.answers[0][1].seq) if found.answers else 1
    if first <= 1:
        return ""
    return f"the recording begins in the middle of the run (seq {first}): what the node remembered then is unknown"


def show(bag: Bag, found: Sequence[Played], console: Console) -> None:
    """A table for people."""
    span = max((f.span for f in found), default=0.0)
    table = Table(title=f"{bag.path}, {span:.1f} s")
    table.add_column("node", no_wrap=True)
    for head in ("answers", "same", "differ", "alone", "x real time"):
        table.add_column(head, justify="right", no_wrap=True)
    for f in found:
        counts = (len(f.answers), f.same, f.different, f.only_bag + f.only_core)
        table.add_row(f.node, *map(str, counts), f"{f.speed:.0f}")
    console.print(table)
    for f in found:
        if f.only_bag or f.only_core:
            only = f"{f.only_bag} answers only in the recording, {f.only_core} only in the replay"
            console.print(f"{f.node}: {only}")
        if f.first:
            console.print(f"{f.node} first differs at {f.first}")
            if since := begun_before(f):
                console.print(f"{f.node}: {since}")
        if f.by_tick or (f.apart and (f.different or f.only_bag)):
            order = (
                "they were played in the order of the ticks" if f.by_tick else "that may be why"
            )
            console.print(
                f"{f.node}: {f.apart} inputs were recorded apart from the sample of their tick: {order}"
            )
    if skipped := max((f.skipped for f in found), default=0.0):
        console.print(f"{skipped:.3g} s without messages, or of a clock that was set, left out")
    if bag.damage:
        console.print(f"the recording is damaged ({bag.damage}): played as far as it goes")


def main() -> None:
    """Entry point of the command."""
    options = parser().parse_args()
    end_with("er replay", lambda: run(options))


def run(options: argparse.Namespace) -> int:
    """Play, compare and show as the options say; the exit status."""
    bag, found, left_out = replayed(options)
    left_out |= incomparable(bag, found)
    for why in left_out.values():
        _say(why)
    text = json.dumps(document(bag, found, left_out), indent=1)
    if options.json == "-":
        print(text)  # noqa: T201  (asked for)
    else:
        if found:
            show(bag, found, Console())
        if options.json:
            write_whole(Path(options.json), text)
    if options.values:
        write_whole(Path(options.values), values(found))
    return status(bag, found, left_out, options)


if __name__ == "__main__":
    main()

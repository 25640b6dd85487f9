"""``er bench lab [PART ...]``: what a diagnosis costs; -h shows all arguments."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from er_models.one_line import OneLine

from er_studies import given_out
from er_studies.bench.lab.measure import LENGTHS, Line, beginnings, length, minute, number
from er_studies.bench.lab.page import page
from er_studies.bench.lab.picture import picture
from er_studies.bench.machine import machine

PARTS: dict[str, Callable[[Path], list[Line]]] = {
    "minute": minute,
    "length": length,
    "number": number,
    "beginnings": beginnings,
    "page": page,
}
TINY: dict[str, Callable[[Path], list[Line]]] = {
    "minute": lambda model: minute(model, seconds=6.0),
    "length": lambda model: length(model, lengths=(6.0, 8.0)),
    "number": lambda model: number(model, seconds=6.0, numbers=(2, 3)),
    "beginnings": lambda model: beginnings(model, seconds=20.0),
    "page": page,
}


def main(arguments: list[str] | None = None) -> None:
    """Measure the parts that are named, or all, and print their tables."""
    parser = OneLine(prog="er bench lab", description=__doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--model", type=Path, default=Path("config/dampers/inove_guo.yaml"))
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures")
    parser.add_argument(
        "--plot", type=Path, metavar="FILE", help="draw cost over length and effects"
    )
    parser.add_argument(
        "--longest", type=float, default=max(LENGTHS), metavar="SECONDS", help="of the lengths"
    )
    parser.add_argument("--tiny", action="store_true", help="seconds of data: only to see it run")
    given = parser.parse_args(arguments)
    unknown = [name for name in given.parts if name not in PARTS]
    if unknown:
        parser.error(f"PART: expected some of {', '.join(PARTS)}, found '{unknown[0]}'")
    names = given.parts or list(PARTS)
    wanted = [n for n in PARTS if n in names or (given.plot and n in ("length", "number"))]
    found, parts = {}, TINY if given.tiny else PARTS | {"length": _up_to(given.longest)}
    for name in wanted:
        found[name] = parts[name](given.model)
        sys.stdout.write(f"## {name}\n\n{table(found[name])}\n")
        sys.stdout.flush()
    here = machine()
    sys.stdout.write(f"## machine\n\n{given_out.markdown(here)}")
    if given.json:
        text = {name: [asdict(line) for line in lines] for name, lines in found.items()}
        text["machine"] = [dict(zip(here.head, here.rows[0], strict=True))]
        given.json.write_text(json.dumps(text, indent=1) + "\n", encoding="utf-8")
    if given.plot:
        picture(found["length"], found["number"], given.plot)


def _up_to(longest: float) -> Callable[[Path], list[Line]]:
    """The measurement of lengths no longer than that."""
    return lambda model: length(model, lengths=tuple(s for s in LENGTHS if s <= longest))


def table(lines: list[Line]) -> str:
    """Lines as a Markdown table."""
    rows = [
        (x.what, f"{x.wall:.1f} s", f"{x.processor:.1f} s", f"{x.memory:.2f} GB", x.found)
        for x in lines
    ]
    return given_out.table(
        ("what", "wall time", "processor time", "peak memory so far", "found"), rows
    )


if __name__ == "__main__":
    main()

"""``er bench models [PART ...] [--json FILE] [--plot FILE] [--tiny]``: cost of prediction and simulation."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from pathlib import Path

from er_models.one_line import OneLine

from er_studies import given_out
from er_studies.bench.machine import machine
from er_studies.bench.models.cases import TINY, Size
from er_studies.bench.models.measure import PARTS
from er_studies.bench.models.picture import picture
from er_studies.bench.models.timing import table


def main(arguments: list[str] | None = None) -> None:
    """Measure the parts that are named, or all, and print their tables."""
    parser = OneLine(prog="er bench models", description=__doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures")
    parser.add_argument(
        "--plot", type=Path, metavar="FILE", help="draw cost over samples and effects"
    )
    parser.add_argument(
        "--tiny", action="store_true", help="short records, no patience: only to see it run"
    )
    given = parser.parse_args(arguments)
    unknown = [name for name in given.parts if name not in PARTS]
    if unknown:
        parser.error(f"PART: expected some of {', '.join(PARTS)}, found '{unknown[0]}'")
    names = given.parts or list(PARTS)
    wanted = [n for n in PARTS if n in names or (given.plot and n in ("length", "number"))]
    size, found = TINY if given.tiny else Size(), {}
    for name in wanted:
        found[name] = PARTS[name](size)
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


if __name__ == "__main__":
    main()

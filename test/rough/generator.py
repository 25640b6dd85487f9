"""Make one case: ``python -m test.rough.generator --seed 1 --case twin/passive --out DIR``; ``--list`` names them."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from test.rough.case import RoughError, make_case
from test.rough.plan import KINDS, plan


def main(argv: list[str] | None = None) -> int:
    """Command line; status 2 with one line where a case cannot be made."""
    parser = argparse.ArgumentParser(prog="rough.generator", description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--case", default="", help="text that its key holds; the first such case is made"
    )
    parser.add_argument("--out", type=Path, help="folder, made where absent")
    parser.add_argument("--list", action="store_true", help="the keys, and nothing is made")
    given = parser.parse_args(argv)
    found = plan(KINDS, [given.seed], match=given.case)
    if given.list or given.out is None:
        sys.stdout.write("".join(f"{a.key}\n" for a in found))
        return 0
    if not found:
        sys.stderr.write(f"--case: expected part of a key, found {given.case}\n")
        return 2
    try:
        case = make_case(found[0], given.out)
    except RoughError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    sys.stdout.write(
        f"{case.asked.key}\n{case.data}\n{case.fresh}\n{case.folder / 'model.yaml'}\n"
    )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

"""Scores the lab on blind data: ``./er exec python -m test.blind_score --kinds singles --seeds 1-10``.

Prints the shares against their targets as Markdown. With ``--results`` every case is noted as soon as it
is known, and a second run makes only what is missing or was made by other code. With ``--condition`` a few
cases of every seed are asked on other benches (``conditions.py``); ``all`` of them, one after the other.
"""

from __future__ import annotations

import argparse
from functools import partial
from typing import Any

from er_models.errors import InputError

from test.blind_score.cases import KINDS, Layout, known, plan
from test.blind_score.conditions import CONDITIONS
from test.blind_score.off import asked_off, off_page, score_off
from test.blind_score.program import collect, finish, heading, parser_of, seeds_of
from test.blind_score.run import score
from test.blind_score.summary import ordered, page


def arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = parser_of("blind_score", __doc__)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, help="by default all")
    parser.add_argument("--effects", nargs="+", help="only these names, `none`, `outside:KIND`")
    parser.add_argument("--condition", nargs="+", choices=["all", *CONDITIONS], metavar="NAME")
    parser.add_argument("--records", type=int, help="records a case; else 1 to 3")
    parser.add_argument("--seconds", type=float, help="length of a record; else 40 to 90 s")
    return parser.parse_args(argv)


def checked(given: argparse.Namespace) -> Layout | None:
    """The layout asked for, if any.

    Raises:
        InputError: an unknown effect, or only half a layout.
    """
    for name in given.effects or []:
        if not known(name):
            raise InputError("--effects", "", "an effect of the generator, or none", name)
    if (given.records is None) != (given.seconds is None):
        raise InputError("--records", "", "--records and --seconds together", "one of them")
    return Layout(given.records, given.seconds) if given.records else None


def main(argv: list[str] | None = None) -> int:
    """Command line."""
    given = arguments(argv)

    def make() -> str:
        size = checked(given)

        def fits(row: dict[str, Any]) -> bool:
            return size is None or (row["records"], row["seconds"]) == (size.records, size.seconds)

        seeds = seeds_of(given.seeds)
        if given.condition:
            names = list(CONDITIONS) if "all" in given.condition else given.condition
            off = {a.key: a for a in asked_off(names, seeds, given.kinds or (), given.effects)}
            rows = collect(given, off, partial(score_off, size=size), lambda r: "condition" in r)
            return off_page(rows, heading(given, rows))
        asked = plan(given.kinds or KINDS, seeds, given.effects)
        rows = collect(given, {a.key: a for a in asked}, partial(score, size=size), fits)
        return page(ordered(rows), heading(given, rows))

    return finish(given, make)


if __name__ == "__main__":
    raise SystemExit(main())

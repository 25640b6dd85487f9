"""Scores the lab on rough data: ``./er exec python -m test.rough_score --seeds 1 --workers 2 --results F.jsonl``.

Prints shares and errors against their targets as Markdown. With ``--results`` every case is noted as soon as it is
known, and a second run makes only what is missing or was made by other code.
"""

from __future__ import annotations

from functools import partial
from typing import Any

from test.blind_score.program import collect, finish, heading, parser_of, seeds_of
from test.blind_score.rows import digest
from test.rough.plan import KINDS, plan
from test.rough_score.run import LIMIT, options, score
from test.rough_score.summary import page

DECIDES = ("src/er_models/er_models", "src/er_model_lab/er_model_lab", "test/rough")
"""Code whose change makes a noted row another one's."""


def main(argv: list[str] | None = None) -> int:
    """Command line."""
    parser = parser_of("rough_score", __doc__)
    parser.add_argument(
        "--kinds", nargs="+", choices=KINDS, default=list(KINDS), help="by default all"
    )
    parser.add_argument("--cases", type=int, help="only the first so many of each seed")
    parser.add_argument("--match", default="", help="only cases whose key holds this text")
    parser.add_argument(
        "--limit",
        type=float,
        default=LIMIT,
        help="processor time for one case [s]",
    )
    parser.add_argument(
        "--measured-terms", action="store_true", help="improve may add terms that are learnt"
    )
    given = parser.parse_args(argv)

    def fits(row: dict[str, Any]) -> bool:
        return bool(row["measured_terms"] == given.measured_terms)

    def make() -> str:
        options(given.measured_terms)
        asked = {
            a.key: a for a in plan(given.kinds, seeds_of(given.seeds), given.cases, given.match)
        }
        one = partial(score, measured_terms=given.measured_terms, limit=given.limit)
        rows = collect(given, asked, one, fits, digest(folders=DECIDES))
        return page(rows, heading(given, rows))

    return finish(given, make)


if __name__ == "__main__":
    raise SystemExit(main())

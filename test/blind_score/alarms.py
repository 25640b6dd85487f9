"""Does the rate of false alarms follow its setting? ``./er exec python -m test.blind_score.alarms --seeds 1-100``.

Complete models of the blind generator, one record of 60 s each. The first round of the search is made once and
decided at several rates, with no smallest size, so that only chance decides. Counted is how often the largest
effect size exceeds the threshold, and how often an effect would be named: it must be steady over blocks, too.
"""

from __future__ import annotations

import argparse
import tempfile
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from er_model_lab.diagnosis.candidates import baseline, effect_size
from er_model_lab.diagnosis.null import simulate_null
from er_model_lab.diagnosis.passing import passes, threshold
from er_model_lab.diagnosis.ranking import refit_all
from er_model_lab.diagnosis.rule import RULE, Rule
from er_model_lab.fitting.velocity_channel import on_fused
from er_model_lab.level.damper import opened
from er_model_lab.verbs.load import load
from er_models.files import load_model
from matplotlib import rc_context
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from test.blind.generator import make_case
from test.blind_score.answer import guarded
from test.blind_score.program import Rows, collect, finish, heading, parser_of, seeds_of
from test.blind_score.run import MODEL
from test.blind_score.summary import table, wilson

RATES = (0.03, 0.1, 0.3)
SECONDS = 60.0
APART = 500_000
"""Seeds of these cases begin here, away from those of the score."""
KINDS = {"over": "largest size over the threshold", "named": "and steady: named"}


def score(seed: int, seconds: float = SECONDS) -> dict[str, Any]:
    """One row: the decision at every rate."""
    return {"key": f"alarm/{seed}", "seed": seed} | guarded(partial(_decided, seed, seconds))


def _decided(seed: int, seconds: float) -> dict[str, Any]:
    """The first round on one complete model."""
    model = load_model(MODEL)
    with tempfile.TemporaryDirectory() as place:
        case = make_case(
            None, APART + seed, out=Path(place) / "data", n_records=1, seconds=seconds
        )
        problem = opened(load(case.directory), model).problem
    base = baseline(on_fused(model), problem)
    found = refit_all(base, problem)
    null, floor = simulate_null(base, found, problem, seed), float(np.sqrt(found[0].mse))
    largest = effect_size(base, found[0])
    limits = [threshold(null, floor, Rule(rate, 0.0)) for rate in RATES]
    return {
        "over": [largest > limit for limit in limits],
        "named": [any(passes(base, c, limit) for c in found) for limit in limits],
        "largest": largest / floor,
        "name": found[0].name,
        "p": null.p_value(largest),
        "by_rule": any(passes(base, c, threshold(null, floor, RULE)) for c in found),
    }


def lines(rows: Rows) -> list[list[str]]:
    """One line for each rate."""
    out = []
    for i, rate in enumerate(RATES):
        cells = [f"{rate:.0%}"]
        for kind in KINDS:
            hits = sum(r[kind][i] for r in rows)
            low, high = wilson(hits, len(rows))
            cells += [f"{hits}/{len(rows)}", f"{low:.1%} to {high:.1%}"]
        out.append(cells)
    return out


def page(rows: Rows, head: str) -> str:
    """The result as Markdown."""
    words = ["`--false-alarm`", "size over", "95 % interval", "named", "95 % interval"]
    default = sum(r["by_rule"] for r in rows)
    largest = max((r["largest"] for r in rows), default=0.0)
    return (
        f"{head}\n\n{table(words, lines(rows))}\nBy the default rule ({RULE.false_alarm:.0%} and {RULE.smallest:.2f} "
        f"of the noise): {default} of {len(rows)}; the largest size is {largest:.2f} of the noise.\n"
    )


def plot(rows: Rows, out: Path) -> None:
    """Rates as found against the rates asked for."""
    with rc_context({"svg.hashsalt": "alarms", "svg.fonttype": "none", "font.size": 9}):
        figure = Figure(figsize=(4.6, 3.6), layout="constrained")
        axes = figure.add_subplot()
        axes.plot([0.0, 0.4], [0.0, 0.4], color="0.6", linewidth=1.0, label="as asked")
        for kind, marker, shift in (("over", "o", -0.003), ("named", "s", 0.003)):
            hits = np.array([sum(r[kind][i] for r in rows) for i in range(len(RATES))])
            ends = np.array([wilson(int(h), len(rows)) for h in hits])
            share = hits / max(len(rows), 1)
            bars = np.abs(ends.T - share)
            axes.errorbar(
                np.array(RATES) + shift, share, bars, fmt=marker, capsize=3, label=KINDS[kind]
            )
        axes.set_xlabel("rate of false alarms asked for")
        axes.set_ylabel(f"rate found in {len(rows)} complete models")
        axes.legend(frameon=False)
        FigureCanvasSVG(figure).print_svg(str(out), metadata={"Date": None})


def arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = parser_of("alarms", __doc__)
    parser.add_argument("--seconds", type=float, default=SECONDS, help="length of a record")
    parser.add_argument("--plot", type=Path, help="write the picture here (SVG)")
    return parser.parse_args(argv)


def main(argv: list[str] | None = None) -> int:
    """Command line."""
    given = arguments(argv)

    def make() -> str:
        jobs = {f"alarm/{s}": s for s in seeds_of(given.seeds)}
        one = partial(score, seconds=given.seconds)
        rows = [r for r in collect(given, jobs, one) if "failed" not in r]
        if given.plot:
            plot(rows, given.plot)
        return page(rows, heading(given, rows))

    return finish(given, make)


if __name__ == "__main__":
    raise SystemExit(main())

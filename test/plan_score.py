"""How far planned programs separate rivals, beside the everyday program: every pair the catalogue calls rivals.

Run as `python -m test.plan_score [--model FILE] [--pairs A:B ...] [--seed N]`; prints rows of a Markdown table.
"""

import argparse
import sys
import time
from pathlib import Path

from er_model_lab.planning.limits import Asked, Limits, limits_of, sensors_of
from er_model_lab.planning.planner import Plan, planned
from er_model_lab.planning.question import KINEMATIC, ask
from er_models.files import load_model
from er_models.model import Model
from threadpoolctl import threadpool_limits

ROOT = Path(__file__).resolve().parents[1]
HEAD = ("pair", "planned", "everyday", "named, planned", "named, everyday", "verdict", "CPU s")


def rivals(model: Model) -> list[tuple[str, str]]:
    """Every pair of effects that the catalogue calls rivals and that can be asked for, once."""
    names = [e.name for e in model.catalogue.candidates() if e.name != KINEMATIC]
    pairs: list[tuple[str, str]] = []
    for name in names:
        for other in model.catalogue[name].signature.rivals:
            known = (other, name) in pairs or (name, other) in pairs
            if other in names and not known:
                pairs.append((name, other))
    return pairs


def row(found: Plan, seconds: float) -> list[str]:
    """One row: the smaller separation that counts, and how often the truth was named."""

    def apart(program: object) -> str:
        return "" if program is None else f"{program.separation(found.counted):.2g}"  # type: ignore[attr-defined]

    def named(outcomes: dict) -> str:
        decided = outcomes.values()
        return f"{sum(o.right for o in decided)} of {sum(o.runs for o in decided)}"

    pair = " / ".join(n if n in found.counted else f"({n})" for n in found.question.names)
    best = found.finalists[0] if found.finalists else None
    return [
        pair, apart(best), apart(found.everyday), named(found.outcomes), named(found.everyday_outcomes),
        found.verdict, f"{seconds:.0f}",
    ]  # fmt: skip


def main(argv: list[str]) -> None:
    """Print the table, a row as soon as it is known."""
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("--model", type=Path, default=ROOT / "config/vehicles/inove_quarter_car.yaml")
    p.add_argument("--pairs", nargs="*", metavar="A:B")
    p.add_argument("--seed", type=int, default=0)
    o = p.parse_args(argv)
    model = load_model(o.model)
    pairs = [tuple(s.split(":")) for s in o.pairs] if o.pairs else rivals(model)
    print("| " + " | ".join(HEAD) + " |\n" + "|---" * len(HEAD) + "|")
    for pair in pairs:
        start = time.process_time()
        with threadpool_limits(1):
            limits = limits_of(model, Asked(), Limits.dt)
            found = planned(
                ask(model, pair, None), limits, sensors_of(model, None)[0], seed=o.seed
            )
        print("| " + " | ".join(row(found, time.process_time() - start)) + " |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])

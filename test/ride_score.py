"""Scores `lab diagnose --level vehicle` on hidden truths: ``./er exec python -m test.ride_score --seeds 1 2``.

The truths come from test/blind, which has equations and an integrator of its own. Prints Markdown.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

from er_model_lab.verbs.diagnose import diagnose
from er_model_lab.verbs.load import load, load_model

from test.blind.catalogue import VEHICLE
from test.blind.generator import make_case

ROOT = Path(__file__).resolve().parents[1]
MODEL = ROOT / "config" / "vehicles" / "inove_quarter_car.yaml"
DAMPER = ("coulomb_friction",)


def scored(name: str, seed: int, seconds: float, without: str) -> str:
    """One line of the table: what was hidden, and what the lab says of three records."""
    with tempfile.TemporaryDirectory() as folder:
        case = make_case(None if name == "none" else name, seed, out=Path(folder), seconds=seconds)
        for path in case.csv:
            leave_out(path, without)
        start = time.process_time()
        result = diagnose(load(folder), load_model(MODEL), level="vehicle").to_dict()
    spent = time.process_time() - start
    named = ", ".join(result["effects"]) or "-"
    ties = "; ".join(", ".join(group) for group in result["alternatives"]) or "-"
    body = result["channels"]["sprung_acceleration"]
    fall = f"{body['rmse']:.3f} to {body['rmse_after']:.3f} m/s2"
    return f"| {name} | {seed} | {result['verdict']} | {named} | {ties} | {fall} | {spent:.0f} s |"


def leave_out(path: Path, column: str) -> None:
    """Take a column out of a CSV file, where it has it."""
    rows = [line.split(",") for line in path.read_text().splitlines()]
    if column in rows[0]:
        at = rows[0].index(column)
        path.write_text("".join(",".join(r[:at] + r[at + 1 :]) + "\n" for r in rows))


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2])
    parser.add_argument(
        "--effects", nargs="+", default=["none", *(e.name for e in VEHICLE), *DAMPER]
    )
    parser.add_argument("--seconds", type=float, default=20.0, help="of each of three records")
    parser.add_argument("--without", default="", help="a column that is not measured")
    args = parser.parse_args()
    head = "hidden | seed | verdict | named | tied | body's error | processor time"
    sys.stdout.write(f"| {head} |\n|---|---|---|---|---|---|---|\n")
    for seed in args.seeds:
        for name in args.effects:
            sys.stdout.write(scored(name, seed, args.seconds, args.without) + "\n")
            sys.stdout.flush()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

"""The monitor's test on errors drawn at random: how often it calls in vain, and how soon it finds a change.

    er study alarms --json alarms.json      1000 hours for each kind of error

Exit status 1 where there are more false alarms than the rules of the test promise.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
from er_model_lab.monitor.sequential import HOUR, RULES
from er_model_lab.monitor.simulated import Drive, alarms, delays
from er_models.files import write_whole
from er_models.one_line import OneLine
from er_models.places import writable
from er_models.seed import seed_reader

from er_studies.progress import progress_of

DRIVES = {
    "white, of one size": Drive(),
    "coloured (0.6), noisy motion": Drive(0.6, (0.02, 0.1, 0.0)),
    "coloured (0.8), noisy motion, model off, gusts of 0.2": Drive(0.8, (0.02, 0.1, 0.001), 0.2),
    "coloured (0.9), noisy motion, model off": Drive(0.9, (0.02, 0.1, 0.001)),
    "coloured (0.6), noisy motion, gusts of 0.5": Drive(0.6, (0.02, 0.1, 0.0), 0.5),
}
"""Kinds of error: how much of a sample is that before, what makes the power, scatter that no motion explains."""
RUNS = 256
"""Runs that share the hours; each learns from its own first minute."""


def figures(drive: Drive, hours: float, seed: int) -> dict[str, float]:
    """`alarms`: false ones in so many hours; time until the rules' change is found, `median` and `late` (95 %) [s]."""
    first, second = np.random.SeedSequence(seed).generate_state(2).tolist()
    took = delays(RULES, drive, 1.0 + RULES.change, RUNS, first)
    return {
        "alarms": alarms(RULES, drive, hours, RUNS, second),
        "median": float(np.median(took)),
        "late": float(np.quantile(took, 0.95)),
    }


def main() -> None:
    """Entry point of the command."""
    p = OneLine(prog="er study alarms", description=(__doc__ or "").split("\n")[0])
    p.add_argument("--hours", type=float, default=1000.0, help="hours of motion a kind (1000)")
    p.add_argument("--seed", type=seed_reader(), default=1, help="seed of the errors (1)")
    p.add_argument("--json", type=Path, help="write the figures here")
    o = p.parse_args()
    writable({"--json": o.json}, None, {})
    kinds: dict[str, dict[str, float]] = {}
    with progress_of("kinds of error") as told:
        for k, (name, drive) in enumerate(DRIVES.items(), 1):
            kinds[name] = figures(drive, o.hours, o.seed)
            if told:
                told(k, len(DRIVES))
    found = {"hours": o.hours, "between": RULES.between / HOUR, "kinds": kinds}
    text = json.dumps(found, indent=1) + "\n"
    sys.stdout.write(text)
    if o.json:
        write_whole(o.json, text)
    most = max(each["alarms"] for each in kinds.values())
    sys.exit(1 if most > o.hours * HOUR / RULES.between else 0)


if __name__ == "__main__":
    main()

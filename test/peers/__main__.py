"""The lab beside what a user would pick instead: ``./er exec python -m test.peers --seeds 4``.

Blind measurements of `test.blind`; every method gets the same fused motion, the same training samples and a model
refitted to them. Prints shares and times of all methods as one Markdown table.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import importlib.util
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from er_common.versions import versions
from er_models.files import load_model

from test.blind.generator import more_records
from test.blind_score.cases import Asked, Layout
from test.blind_score.fresh import fresh_errors
from test.blind_score.rows import digest
from test.blind_score.run import ANOTHER, MODEL, ROOT, drawn
from test.peers.data import Answer, Given, given

SIZE = Layout(2, 30.0)
EFFECTS = (
    "coulomb_friction", "preload", "gas_spring", "quadratic_damping", "asymmetric_damping", "shear_thinning",
    "bouc_wen_hysteresis", "end_stop", "field_viscosity", "dead_time", "rise_fall_asymmetry", "force_lag",
)  # fmt: skip
COMPLETE = 4
"""Complete models for each seed."""
REQUIREMENTS = ROOT / "requirements" / "peers.txt"
TITLES = {
    "lab": "this lab, `improve`",
    "pysindy": "PySINDy (STLSQ), library of the same terms",
    "trees": "gradient-boosted trees on the residual",
    "bic": "SciPy least squares and BIC, same effects",
}


def install() -> None:
    """Bring the pinned peers into the environment; one line says so."""
    if importlib.util.find_spec("pysindy"):
        return
    pinned = [line for line in REQUIREMENTS.read_text().split("\n") if line and line[0] != "#"]
    print(f"installing {', '.join(pinned)} into the environment", file=sys.stderr)
    command = [
        sys.executable,
        "-m",
        "pip",
        "install",
        "--quiet",
        "--no-deps",
        "-r",
        str(REQUIREMENTS),
    ]
    if subprocess.run(command, check=False).returncode:
        sys.exit(f"{REQUIREMENTS}: pip could not install it (no network?)")


def timed(work: Callable[[], Answer]) -> Answer:
    """An answer with the processor time it took."""
    began = time.process_time()
    found = work()
    return replace(found, seconds=time.process_time() - began)


def answers(task: Given, asked: Asked, data: Path) -> dict[str, Answer]:
    """What every method says; the time of the peers begins with the fused motion, that of the lab with the files."""
    from test.peers import boosted, lab, least_squares, sindy

    return {
        "lab": timed(lambda: lab.answer(task, data, load_model(MODEL), asked.seed)),
        "pysindy": timed(lambda: sindy.answer(task)),
        "trees": timed(lambda: boosted.answer(task)),
        "bic": timed(lambda: least_squares.answer(task)),
    }


def row(asked: Asked) -> dict[str, Any]:
    """One case: what was hidden, and what every method said."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        case, _ = drawn(asked, SIZE, folder)
        fresh = more_records(case, case.seed + ANOTHER // 2, out=folder / "fresh", n_records=1)
        task = given(load_model(MODEL), case.directory, fresh.directory)
        least = fresh_errors(fresh, task.model)["truth"]
        found = answers(task, asked, case.directory)
    said = {
        key: {"names": list(a.names), "ratio": a.rms / least, "seconds": a.seconds}
        for key, a in found.items()
    }
    return {"hidden": list(asked.hidden), "seed": asked.seed, "said": said}


def table(rows: list[dict[str, Any]]) -> str:
    """All methods side by side."""
    hidden, complete = ([r for r in rows if bool(r["hidden"]) is kind] for kind in (True, False))
    lines = [
        "| method | right name first | false name on complete models | error on fresh data over the truth's, "
        "median (worst) | the same, complete models | processor time a case [s] |",
        "|---|---|---|---|---|---|",
    ]
    for key, title in TITLES.items():
        named = key != "trees"
        first = sum(r["said"][key]["names"][:1] == r["hidden"] for r in hidden)
        false = sum(bool(r["said"][key]["names"]) for r in complete)
        lines.append(
            f"| {title} | {_share(first, len(hidden)) if named else 'names nothing'} "
            f"| {_share(false, len(complete)) if named else '-'} | {_spread(hidden, key, 'ratio')} "
            f"| {_spread(complete, key, 'ratio')} | {np.median([r['said'][key]['seconds'] for r in rows]):.1f} |"
        )
    return "\n".join(lines)


def _share(part: int, whole: int) -> str:
    """A share with its counts."""
    return f"{part} of {whole} ({part / whole:.0%})" if whole else "none asked"


def _spread(rows: list[dict[str, Any]], key: str, what: str) -> str:
    """Median and worst."""
    values = [r["said"][key][what] for r in rows]
    return f"{np.median(values):.2f} ({max(values):.2f})" if values else "-"


def main() -> None:
    """Parse, compare, print."""
    parser = argparse.ArgumentParser(prog="python -m test.peers", description=__doc__)
    parser.add_argument("--seeds", type=int, default=1, help="how many; the first is --first")
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--effects", nargs="*", default=list(EFFECTS))
    parser.add_argument("--complete", type=int, default=COMPLETE, help="complete models a seed")
    parser.add_argument("--json", type=Path, help="every answer")
    parser.add_argument("--noted", action="store_true", help="ask nothing, show what --json holds")
    wanted = parser.parse_args()
    if wanted.noted:
        rows = json.loads(wanted.json.read_text(encoding="utf-8"))
        print(f"{table(rows)}\n\n{footer(rows)}")
        return
    install()
    rows = []
    for seed in range(wanted.first, wanted.first + wanted.seeds):
        asked = [Asked("singles", (e,), seed) for e in wanted.effects]
        asked += [Asked("complete", (), 100 * seed + i) for i in range(wanted.complete)]
        for one in asked:
            rows.append(row(one))
            if sys.stderr.isatty():
                print(f"{len(rows)}: {one.key}", file=sys.stderr)
            if wanted.json:
                wanted.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    print(f"{table(rows)}\n\n{footer(rows)}")


def footer(rows: list[dict[str, Any]]) -> str:
    """What the table was made of, and by which versions."""
    seeds = sorted({r["seed"] for r in rows if r["hidden"]})
    names = ("pysindy", "scikit-learn", "scipy")
    made_by = ", ".join(f"{n} {importlib.metadata.version(n)}" for n in names)
    return (
        f"{len(rows)} cases of {SIZE.records} records of {SIZE.seconds:g} s, seeds {seeds}; er_model_lab "
        f"{versions()['er_model_lab']}, code {digest()}; {made_by}."
    )


if __name__ == "__main__":
    main()

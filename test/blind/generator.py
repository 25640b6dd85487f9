"""Make measurements with a hidden effect: ``python -m test.blind.generator --help``."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from test.blind.calibrate import LEAST_RISE, MOST_RISE, clean_records, hide, scene_of, table_of
from test.blind.case import Case, check_free, excess_after_refit, write
from test.blind.catalogue import INSIDE, OUTSIDE, choose
from test.blind.effect import Effect
from test.blind.errors import BlindError
from test.blind.measure import Noise, with_noise
from test.blind.plant import Program, Rig, draw_base, draw_motions, within_limits

__all__ = ["INSIDE", "OUTSIDE", "Case", "excess_after_refit", "main", "make_case", "more_records"]

_ROAD_TRIALS = 3
_REDRAWS = 4
_CHOICE, _BASE, _MOTION, _NOISE, _EFFECT = range(5)


def _stream(seed: int, part: int, *more: int) -> np.random.Generator:
    """Independent random numbers for one part of a case, so that parts can change alone."""
    return np.random.default_rng([seed, part, *more])


def _simulated(case: Case) -> Case:
    """The case with its noiseless records."""
    clean = clean_records(case.motions, case.table, case.base, case.seconds)
    return replace(case, clean=tuple(clean))


def _finished(case: Case) -> Case:
    """The simulated case with its records made noisy and written."""
    noisy = [
        with_noise(record, case.noise, _stream(case.seed, _NOISE, index))
        for index, record in enumerate(case.clean)
    ]
    done = replace(case, noisy=tuple(noisy))
    write(done)
    return done


def _shown(case: Case, chosen: list[Effect], target: float | None) -> Case:
    """The case with effects that show by 10 to 600 % together; shapes, signs and strengths redrawn until they do.

    Raises:
        BlindError: they never did; a single effect says so by itself.
    """
    found = []
    for trial in range(_REDRAWS):
        full = _simulated(_hidden(case, chosen, target, trial))
        shown = any(one.shown_by_force for one in chosen)
        found.append(excess_after_refit(full) if shown else LEAST_RISE)
        if LEAST_RISE <= found[-1] <= MOST_RISE:
            return full
    names, rises = ", ".join(e.name for e in chosen), ", ".join(f"{r:.1%}" for r in found)
    raise BlindError(f"{names}: expected a rise of 10 to 600 % together, found {rises}")


def _hidden(case: Case, chosen: list[Effect], target: float | None, trial: int) -> Case:
    """The case with calibrated effects, its roads smaller where they let the car move too much."""
    motions, floor = case.motions, case.noise.force
    for _ in range(_ROAD_TRIALS):
        scene = scene_of(motions, case.base, case.seconds)
        more = [trial] if trial else []
        streams = [_stream(case.seed, _EFFECT, one.slot, *more) for one in chosen]
        hidden = tuple(
            hide(one, motions, scene, floor, rng, target)
            for one, rng in zip(chosen, streams, strict=True)
        )
        case = replace(case, motions=motions, hidden=hidden)
        smaller = within_limits(motions, table_of(hidden), case.base)
        if smaller is motions:
            break
        motions = smaller
    return case


def make_case(
    effect: str | list[str] | None,
    seed: int,
    *,
    out: Path,
    n_records: int = 3,
    seconds: float | None = None,
    rig: Rig = "car",
    noise: Noise | None = None,
    target: float | None = None,
) -> Case:
    """Measurements of an ER damper with hidden effects, written to a folder.

    Args:
        effect: contract name, ``outside:<kind>``, ``random``, several of them, or None for a
            complete model.
        seed: of everything that is drawn; the same seed has the same base, motion and noise
            whatever the effect, except that roads
            shrink where an effect would let the car move too fast.
        out: folder of the case; made where absent.
        n_records: number of records.
        seconds: length of a record [s]; drawn from 20 to 30 where absent.
        rig: ``car`` on a road, or ``damper`` with an imposed stroke.
        noise: of the instruments.
        target: rise of the residual over the force noise after a healthy base is refitted, 0.1
            being 10 %; drawn for each effect where absent.

    Raises:
        BlindError: an unknown effect, an occupied folder, a target out of reach, or effects that hide one
            another.
    """
    if n_records < 1 or (seconds is not None and seconds < 2.0):
        raise BlindError("case: expected at least one record of at least 2 s")
    check_free(out)
    noise = noise or Noise()
    chosen = choose(effect, _stream(seed, _CHOICE))
    rng = _stream(seed, _BASE)
    base = draw_base(rng)
    length = seconds if seconds is not None else round(2.0 * rng.uniform(20.0, 30.0)) / 2.0
    motion_seed = np.random.SeedSequence([seed, _MOTION])
    motions = tuple(draw_motions(rig, "rich", n_records, length, base, motion_seed))
    case = Case(out, seed, rig, "rich", length, base, (), noise, motions, (), ())
    return _finished(_shown(case, chosen, target))


def more_records(
    case: Case,
    seed: int,
    *,
    out: Path,
    n_records: int = 3,
    seconds: float | None = None,
    program: Program = "rich",
) -> Case:
    """Fresh records of the same truth on other roads, with other duties and noise.

    Args:
        case: where the truth comes from; it is not changed.
        seed: of the motion and the noise.
        out: folder of the new case.
        n_records: number of records.
        seconds: length of a record [s]; as in the case where absent.
        program: ``rich``, or poor inputs: one ``constant_duty``, or ``one_sine`` at one duty.

    Raises:
        BlindError: an occupied folder.
    """
    check_free(out)
    length = seconds if seconds is not None else case.seconds
    motion_seed = np.random.SeedSequence([seed, _MOTION])
    motions = draw_motions(case.rig, program, n_records, length, case.base, motion_seed)
    other = replace(
        case,
        directory=out,
        seed=seed,
        program=program,
        seconds=length,
        motions=tuple(motions),
    )
    return _finished(_simulated(other))


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="generator", description=__doc__)
    parser.add_argument("--effect", nargs="+", required=True, help="name(s), none or random")
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--out", type=Path, required=True, help="folder of the case")
    parser.add_argument("--records", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=None, help="of a record; else 20 to 30")
    parser.add_argument("--rig", choices=("car", "damper"), default="car")
    parser.add_argument("--force-noise", choices=("white", "ar1"), default="white")
    return parser.parse_args(argv)


def main(argv: list[str] | None = None) -> int:
    """Command line; names the files and nothing of the truth."""
    args = _arguments(argv)
    effect = None if args.effect == ["none"] else args.effect
    try:
        case = make_case(
            effect,
            args.seed,
            out=args.out,
            n_records=args.records,
            seconds=args.seconds,
            rig=args.rig,
            noise=Noise(kind=args.force_noise),
        )
    except BlindError as error:
        sys.stderr.write(f"{error}\n")
        return error.exit_status
    sys.stdout.write("".join(f"{path}\n" for path in case.csv))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

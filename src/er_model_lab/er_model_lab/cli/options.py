"""Arguments and options that the commands of the lab share."""

from __future__ import annotations

from argparse import ArgumentTypeError
from pathlib import Path
from typing import Annotated, Any

import typer
from er_models.errors import ErError, InputError
from er_models.seed import seed_reader


def seed_option(text: str) -> Any:
    """The option `--seed` with its help."""

    def read(value: str) -> int:
        try:
            return seed_reader()(value)
        except ArgumentTypeError as error:
            raise typer.BadParameter(str(error)) from None

    return typer.Option(parser=read, metavar="INTEGER", help=text)


Data = Annotated[
    list[Path],
    typer.Argument(
        metavar="DATA",
        help="rosbag2 folder, .mcap, .csv, .parquet, .mf4, .mat, .tdms, .xlsx, or a folder of them.",
    ),
]
ModelFile = Annotated[
    Path, typer.Option("--model", help="Model file (YAML), e.g. config/dampers/inove_guo.yaml.")
]
ModelFiles = Annotated[
    list[Path],
    typer.Option(
        "--model",
        metavar="PATH",
        help="Model file (YAML); repeatable, further ones are set beside it.",
    ),
]
Json = Annotated[
    Path | None, typer.Option("--json", help="Write the machine-readable result here.")
]
Report = Annotated[
    Path | None,
    typer.Option("--report", help="Write a self-contained HTML report into this folder."),
]
Level = Annotated[
    str,
    typer.Option(
        help="damper: force from measured motion and duty; vehicle: force and motion from road and duty."
    ),
]
Seed = Annotated[int, seed_option("Seed of everything random.")]
HoldOut = Annotated[
    list[Path] | None,
    typer.Option(
        "--hold-out",
        metavar="PATH",
        help="Data that score and are never used to fit; improve refuses what makes them worse. Repeatable.",
    ),
]
Out = Annotated[Path, typer.Option("--out", help="New model file.")]
FalseAlarm = Annotated[
    float,
    typer.Option(
        "--false-alarm",
        help="Allowed probability of a false alarm: an effect is named although the model is complete. "
        "Above 0 and below 1.",
    ),
]
Smallest = Annotated[
    float, typer.Option(help="Effects smaller than this share of the noise are given no name.")
]
Helps = Annotated[
    float,
    typer.Option(
        help="Effects that explain less than this share of what is explainable are not taken. Lower it for "
        "measured data, where no equation fits exactly and the error falls in many small steps."
    ),
]
Anyway = Annotated[
    bool,
    typer.Option(
        "--anyway", help="Use data that fail the preflight all the same (exit status 3)."
    ),
]
MeasuredTerms = Annotated[
    bool,
    typer.Option(
        "--measured-terms",
        help="Learn what no known effect explains as one smooth term, measured and not explained.",
    ),
]
EffectsFrom = Annotated[
    list[Path] | None,
    typer.Option(
        "--effects-from", metavar="FILE", help="Python file with effects of your own. Repeatable."
    ),
]

OPTIONS = {
    "data": "DATA", "held_out": "--hold-out", "level": "--level", "report": "--report", "seed": "--seed",
    "false_alarm": "--false-alarm", "smallest": "--smallest", "helps": "--helps", "stroke": "--stroke",
    "velocity": "--velocity", "duty_max": "--duty-max", "duration": "--duration", "fmi": "--fmi", "by": "--by",
}  # fmt: skip
"""Arguments of the lab's functions and the options that stand for them."""
PHRASES = {
    "anyway=True": "--anyway",
    "level='vehicle'": "--level vehicle",
    "either between, two effects, or reveal, one,": "either --between EFFECT EFFECT or --reveal EFFECT,",
    "between: expected": "--between: expected",
    "held_out: expected": "--hold-out: expected",
    "report: expected a folder": "--report: expected a folder",
    "limits (stroke, velocity, duration)": "limits (--stroke, --velocity, --duration)",
    "set helps to": "set --helps to",
    "resume=True": "--resume",
    "measured_terms=True": "--measured-terms",
    "something to write: series, lut, c or fmu": "something to write: --series, --lut, --c or --fmu",
}
"""Arguments in sentences, as the command line writes them."""


def in_options(error: ErError) -> str:
    """An error in one line, in the words of the command line."""
    said = " ".join(str(error).split())
    if isinstance(error, InputError) and error.path in OPTIONS:
        said = OPTIONS[error.path] + said.removeprefix(error.path)
    return str(worded(said))


def worded(value: Any) -> Any:
    """Plain data whose sentences are in the words of the command line."""
    if isinstance(value, dict):
        return {key: worded(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(worded(each) for each in value)
    if isinstance(value, str):
        for argument, option in PHRASES.items():
            value = value.replace(argument, option)
    return value

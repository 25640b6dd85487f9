"""What a study gives out: tables for people, figures for programs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from er_models.files import write_whole
from rich.console import Console

Out = Annotated[Path | None, typer.Option(help="Write the tables here as well.")]
Json = Annotated[Path | None, typer.Option("--json", help="Write the figures here.")]


def say(text: str, out: Path | None = None) -> None:
    """Print Markdown, for people and for files: no wrapping, no colours; out: a file that gets it as well."""
    Console(soft_wrap=True, markup=False, highlight=False).print(text)
    if out is not None:
        write_whole(out, text + "\n")


def write_json(file: Path | None, content: Any) -> None:
    """Write figures where a file is asked for; arrays become lists.

    Raises:
        ValueError: a figure that JSON does not know.
    """
    if file is not None:
        text = json.dumps(content, indent=1, allow_nan=False, default=np.ndarray.tolist)
        write_whole(file, text + "\n")

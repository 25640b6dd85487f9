"""The stopwatch of docs/my_rig.md: its commands, one after the other, as a user who types them."""

from __future__ import annotations

import re
import resource
import shlex
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from er_models.errors import InputError

from er_studies.bench.lab.measure import Line

PAGE, OWN = Path("docs/my_rig.md"), "mine"
"""The page, and the name that it gives to a copy of its data."""
_BLOCK = re.compile(r"^```sh\n(.*?)^```", re.M | re.S)


def commands(page: Path = PAGE) -> list[list[str]]:
    """What follows `./er` in each command of the page, in order."""
    text = page.read_text(encoding="utf-8")
    lines = [line for block in _BLOCK.findall(text) for line in block.splitlines()]
    return [shlex.split(line, comments=True)[1:] for line in lines if line.startswith("./er ")]


def followed(root: Path, folder: Path) -> Iterator[Line]:
    """Each command of the page as it ends, run in a folder with a copy of the page's data.

    root: of the repository; memory is the peak of all commands so far.

    Raises:
        InputError: A command failed, or root is another folder.
    """
    if not (root / PAGE).is_file():
        raise InputError(root, PAGE.name, f"the repository, with {PAGE}", "no such page")
    shutil.copytree(root / "docs" / "my_rig" / "messung", folder / OWN)
    for words in commands(root / PAGE):
        before, start = _processor(), time.perf_counter()
        done = subprocess.run(
            [str(root / "er"), *words], cwd=folder, capture_output=True, text=True, check=False
        )
        wall = time.perf_counter() - start
        if done.returncode:
            said = (done.stderr or done.stdout).strip().splitlines()[-1:]
            raise InputError(PAGE, " ".join(words), "exit status 0", f"{done.returncode}: {said}")
        peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024 / 1e9
        last = done.stdout.strip().splitlines()[-1].strip()
        yield Line(" ".join(words[:2]), 1.0, wall, _processor() - before, last, peak)


def page(model_file: Path) -> list[Line]:
    """All commands of the page, and their sum."""
    del model_file
    with tempfile.TemporaryDirectory() as name:
        lines = list(followed(Path.cwd(), Path(name)))
    wall, processor = (sum(getattr(x, k) for x in lines) for k in ("wall", "processor"))
    return [*lines, Line("the whole page", len(lines), wall, processor, "", lines[-1].memory)]


def _processor() -> float:
    """Processor time of all commands that have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime

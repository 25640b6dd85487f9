"""Tables of the result pages: ``./er exec python -m test.result_tables [RUN FILE]``.

Without arguments it writes every table anew from what is stored, and says which were made by other code. With RUN and
the FILE that its command wrote (`--json FILE`, `--table FILE`) it stores that first.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from er_models.errors import InputError
from er_models.files import write_whole

from test.result_tables.stored import DATA, within
from test.result_tables.tables import RUNS, TABLES


def written(pages: Path = DATA.parent) -> None:
    """Write every table into its page."""
    for name, (run, table) in TABLES.items():
        page = pages / run.page
        text = page.read_text(encoding="utf-8")
        i, j = within(text, name)
        write_whole(page, text[:i] + table(run.stored()["values"]) + text[j:])


def main(argv: list[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser("result_tables", description=__doc__)
    parser.add_argument("run", nargs="?", choices=list(RUNS), help="run whose figures are stored")
    parser.add_argument("file", nargs="?", type=Path, help="what its command wrote")
    given = parser.parse_args(argv)
    try:
        if given.run is not None:
            if given.file is None:
                parser.error(
                    f"{given.run} needs the file that `./er {RUNS[given.run].command}` wrote"
                )
            RUNS[given.run].store(given.file)
        written()
    except InputError as error:
        sys.stderr.write(f"result_tables: {error}\n")
        return 2
    for run in RUNS.values():
        stored = run.stored()["code"]
        same = "as it is" if stored == run.code else f"older, {stored}: run it again"
        print(f"{run.name:16} ./er {run.command} {run.writes}    (code: {same})")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

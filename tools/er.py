"""Entry point of ``./er``: runs on the system's Python with nothing but the standard library."""

import sys

if __name__ == "__main__":
    try:
        from pathlib import Path

        sys.path.insert(0, str(Path(__file__).resolve().parent))
        from er_workspace.commands import main

        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        # main answers Ctrl-C itself: this one came while it was imported
        sys.stderr.write("er: interrupted\n")
        sys.exit(130)

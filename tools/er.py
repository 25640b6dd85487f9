"""Entry point of ``./er``: runs on the system's Python with nothing but the standard library."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from er_workspace.commands import main

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

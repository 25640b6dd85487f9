"""The long runs behind docs/results/reliability.md.

python -m test.reliability faults                 delay of detection of each fault, false alarms (virtual time)
python -m test.reliability fuzz [COUNT]           messages of any content at every input
python -m test.reliability kill [TIMES]           kill -9 of each node of a running graph, and how soon it is back
python -m test.reliability silence [DRIVES]       how soon observers are sure again after a silent sensor
python -m test.reliability hog [SECONDS [PRIORITY]]   two busy loops beside the running graph
python -m test.reliability hold [TIMES]           a recorder that is held up: what its recording lacks
python -m test.reliability soak [SECONDS [PRIORITY]]  a running graph with a fault injected each minute
python -m test.reliability table [--times TIMES]  every test that holds a row of the table of faults

PRIORITY: real-time priority of the nodes.

Exit status 1 where something is not as docs/results/reliability.md says.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import import_module

DEFAULTS = {
    "faults": 600,
    "fuzz": 1_000_000,
    "kill": 20,
    "silence": 8,
    "hog": 10,
    "hold": 2,
    "soak": 1800,
    "table": 3,
}


def main() -> int:
    """Run what is named; its exit status."""
    name = sys.argv[1] if len(sys.argv) > 1 else ""
    if name not in DEFAULTS:
        sys.stdout.write(__doc__ or "")
        return 0 if name in ("", "-h", "--help") else 2
    amounts = [int(word) for word in sys.argv[2:] if word != "--times"] or [DEFAULTS[name]]
    run: Callable[..., int] = import_module(f"test.reliability.{name}").run
    return run(*amounts)


if __name__ == "__main__":
    sys.exit(main())

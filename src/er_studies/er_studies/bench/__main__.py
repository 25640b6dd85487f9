"""``er bench``: measures speed; figures hold for the machine and the moment, ratios for longer.

er bench models [ARGS]     prediction and simulation, against SciPy and C in the same run; their memory
er bench observers [ARGS]  one step of every observer and of the Kalman filters beside them; load, memory
er bench lab [ARGS]        diagnosis and improvement: a minute, more data, more effects; their memory
er bench graph [ARGS]      lost messages, latency and CPU of the running graph
er bench ros [ARGS]        loop latency and CPU, in processes and composed, beside plain rclpy executors

-h after a name shows its arguments.
"""

from __future__ import annotations

import runpy
import sys

PARTS = {
    "models": "er_models.bench",
    "observers": "er_observers.bench",
    "lab": "er_studies.bench.lab",
    "graph": "er_bringup.bench_graph",
    "ros": "er_bringup.bench_ros",
}


def main() -> None:
    """Hand over to the benchmark that is named."""
    name = sys.argv[1] if len(sys.argv) > 1 else ""
    if name in ("", "-h", "--help"):
        sys.stdout.write((__doc__ or "") + "\n")
        sys.exit(0)
    if name not in PARTS:
        sys.stderr.write(f"er bench: expected one of {', '.join(PARTS)}, found '{name}'\n")
        sys.exit(2)
    sys.argv = [f"er bench {name}", *sys.argv[2:]]
    runpy.run_module(PARTS[name], run_name="__main__")


if __name__ == "__main__":
    main()

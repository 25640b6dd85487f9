"""``er bench``: measures speed; figures hold for the machine and the moment, ratios for longer.

er bench models [ARGS]     prediction and simulation, against SciPy and C in the same run; their memory
er bench observers [ARGS]  one step of every observer and of the Kalman filters beside them; load, memory
er bench lab [ARGS]        diagnosis and improvement: a minute, more data, more effects; their memory
er bench fleet [ARGS]      a fleet of recordings with one and two workers; a simulated cluster
er bench graph [ARGS]      lost messages, latency and CPU of the running graph
er bench ros [ARGS]        loop latency and CPU, in processes and composed, beside plain rclpy executors
er bench wire [ARGS]       frames of the hardware bridge with and without authentication

-h after a name shows its arguments.
"""

from __future__ import annotations

from er_studies.programs import hand_over

PARTS = {
    "models": "er_studies.bench.models",
    "observers": "er_studies.bench.observers",
    "lab": "er_studies.bench.lab",
    "fleet": "er_studies.bench.fleet",
    "graph": "er_studies.bench.graph",
    "ros": "er_studies.bench.ros",
    "wire": "er_studies.bench.wire",
}


def main() -> None:
    """Hand over to the benchmark that is named."""
    hand_over("er bench", PARTS, __doc__ or "")


if __name__ == "__main__":
    main()

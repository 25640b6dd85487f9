"""What the sensors of the quarter car report of a true motion: the sensing effects, run the other way round.

The prediction maps the measured motion to the true one; the plant has the true one and must report
the measured. The numbers in `reading` come from the same hooks (`er_models.reading`).

The text below the marker is compiled together with the equations of a catalogue
(`kernel.compose`).
"""

from __future__ import annotations

from er_models.kernel.fast import inner
from er_models.kernel.imposed import output_delay
from er_models.kernel.inputs import between
from er_models.kernel.states import held


def accelerometers(on, p, a_s, a_us):  # type: ignore[no-untyped-def]
    """Composed from the catalogue: reported accelerations of both masses [m/s2]."""
    raise NotImplementedError("replaced by kernel.compose")


# --- below this line: compiled with the composed equations ---
@inner
def remember_velocity(reading, memory, v_0, v_1, h):
    """Bring the reported velocity, memory[0], over a step: v = offset + gain v_m + lag v_m'."""
    gain, lag, offset = reading[2], reading[3], reading[4]
    if lag > 0.0:
        pace = gain / lag
        memory[0] = held(memory[0], pace, (v_0 - offset) / lag, pace, (v_1 - offset) / lag, h)
    else:
        memory[0] = (v_1 - offset) / gain


@inner
def remember_force(memory, f_m):
    """Append to the forces of the last steps, memory[1:], oldest first."""
    for i in range(1, memory.shape[0] - 1):
        memory[i] = memory[i + 1]
    memory[memory.shape[0] - 1] = f_m


@inner
def report(on, p, q, reading, memory, h, out, k):
    """Turn row k of out into what the sensors say of accelerations, force, deflection and velocity."""
    out[k, 0], out[k, 1] = accelerometers(on, p, out[k, 0], out[k, 1])
    late = output_delay(on, p) / h
    if late > 0.0:
        out[k, 3] = between(memory[1:], memory.shape[0] - 2 - late)
    out[k, 4] = (q[0] - reading[1]) / reading[0]
    out[k, 5] = memory[0]

"""Damper force along an imposed motion, one sample after another: `imposed.predict` for who cannot wait for the rest.

The text below the marker is compiled together with the equations of a catalogue
(`kernel.compose`).
"""

from __future__ import annotations

from er_models.kernel.fast import entry
from er_models.kernel.imposed import input_delay, output_delay, stop, stops, turning
from er_models.kernel.inputs import at, between, cubic, split
from er_models.kernel.states import HOLD, keep, visit


# --- below this line: compiled with the composed equations ---
@entry
def advance(
    on, slots, links, p, states, dt, t, before, now, apart, duties, n_sub, forces, shown
):  # fmt: skip
    """Bring m dampers from the sample before, at t [s], to the next one, in place; the forces shown there (m,) [N].

    states (m, ROWS, n_states); before, now (5,): deflection, velocity, acceleration, duty and temperature at both
    samples; apart (m,): what each damper moves faster [m/s]; duties: held from each sample on, this one's last, three
    more than the dead time has samples at least; forces (m, n): of the last samples, this one's last.
    """
    whole, cut = split(input_delay(on, p) / dt)
    shift, last = output_delay(on, p) / dt, duties.shape[0] - 1 - whole
    a_rise, theta_rise = now[2] - before[2], now[4] - before[4]
    turn = turning(cut, n_sub)
    for i in range(states.shape[0]):
        s, v_0, v_1 = states[i], before[1] + apart[i], now[1] + apart[i]
        x, v = cubic(before[0], v_0, now[0], v_1, dt), cubic(v_0, before[2], v_1, now[2], dt)
        # a change without a part of a sample was looked at in the sample before
        u_now, u_next = duties[last - 2 if cut > 0.0 else last - 1], duties[last - 1]
        jump, h, end, f_m = u_now != u_next, dt / n_sub, 0.0, 0.0
        for j in range(stops(n_sub, jump, cut, False)):
            q = (j + 1) / n_sub
            if jump:
                q, u_now = stop(j, n_sub, turn, cut, u_now, u_next)
                h, end = (q - end) * dt, q
            _, f_m, _ = visit(
                on, links, p, s, h, HOLD, at(x, q), at(v, q), before[2] + q * a_rise, u_now,
                t + q * dt, before[4] + q * theta_rise,
            )  # fmt: skip
            keep(slots, s)
        if cut == 0.0 and duties[last] != u_now:
            for k in range(last - 1, last + 1):
                _, f_m, _ = visit(
                    on, links, p, s, 0.0, HOLD, now[0], v_1, now[2], duties[k], t + dt, now[4],
                )  # fmt: skip
                keep(slots, s)
        past = forces[i]
        for k in range(past.shape[0] - 1):
            past[k] = past[k + 1]
        past[-1] = f_m
        shown[i] = between(past, past.shape[0] - 1.0 - shift) if shift != 0.0 else f_m

"""The duty of any peer, compiled; without what tunes them, whose constants another package holds."""

from __future__ import annotations

from er_models.model import Array

from er_studies.control.peers.clipped_lqr import duty as clipped_lqr
from er_studies.control.peers.constant import duty as constant
from er_studies.control.peers.linear_skyhook import duty as linear_skyhook
from er_studies.control.peers.mpc import duty as mpc
from er_studies.control.peers.pdd import duty as pdd
from er_studies.control.peers.sample import compiled
from er_studies.control.peers.sh_add import duty as sh_add
from er_studies.control.peers.skyhook import duty as skyhook


@compiled
def duty(number: int, p: Array, s: Array, u_max: float) -> float:
    """Duty of a peer for a sample, within the limits."""
    if number == 0:
        u = constant(p, s)
    elif number == 1:
        u = skyhook(p, s)
    elif number == 2:
        u = linear_skyhook(p, s)
    elif number == 3:
        u = sh_add(p, s)
    elif number == 4:
        u = pdd(p, s)
    elif number == 5:
        u = clipped_lqr(p, s)
    else:
        u = mpc(p, s, u_max)
    return min(max(u, 0.0), u_max)

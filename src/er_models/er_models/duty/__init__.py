"""Programs of the duty, one small file each; `duty_profile` makes any of them from settings."""

from __future__ import annotations

from collections.abc import Mapping

from er_models.duty import constant, recorded, sequence, sine, square, stairs, steps
from er_models.spec import Array, Kind, choose, settings

_SINGLE = {module.KIND.name: module.KIND for module in (constant, steps, stairs, square, sine)}
_SEVERAL = sequence.kind(_SINGLE)

KINDS: dict[str, Kind] = {
    **_SINGLE,
    recorded.KIND.name: recorded.KIND,
    _SEVERAL.name: _SEVERAL,
}


def duty_profile(spec: Mapping[str, object], t: Array, seed: int = 0) -> Array:
    """Duty [1], 0 to 1, at the times t [s], shape (n,).

    spec: `kind`, one of `KINDS`, and its settings. The duty at a time does not depend on which
    other times are asked for. Raises `InputError` for an unknown kind or key and for a value out
    of bounds.
    """
    kind = choose(KINDS, spec, "duty")
    return kind.make(settings(kind.settings, spec, "duty"), t, seed)

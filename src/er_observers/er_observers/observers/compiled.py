"""How the loops of observers and filters are compiled."""

from __future__ import annotations

from er_models.cache.compiled import on_disk

compiled = on_disk(error_model="numpy")

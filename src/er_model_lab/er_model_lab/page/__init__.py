"""The lab in a browser: the only place that knows the framework (NiceGUI); what it shows is `er_model_lab.session`."""

import sys

CLIENTS = ("tornado", "aiohttp")
"""Packages that the framework's sockets import where they are there, which only who asks a server needs."""
_absent = [name for name in CLIENTS if name not in sys.modules]
for _name in _absent:
    sys.modules[_name] = None  # type: ignore[assignment]  # its import fails, and the framework does without
try:
    import nicegui  # noqa: F401
finally:
    for _name in _absent:
        del sys.modules[_name]

"""The one error a user of the generator can cause."""

from __future__ import annotations


class BlindError(Exception):
    """A case that cannot be made; the message is one line, the exit status is 2."""

    exit_status = 2

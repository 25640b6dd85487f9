"""What not everybody installs: the extras of our packages, imported when something asks for them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from er_models.errors import ErError


@contextmanager
def extra(wanted: str, use: str) -> Iterator[None]:
    """Import within it what belongs to an extra of a package.

    wanted: what to install, `package[extra]`; use: what it is needed for, as the beginning of the line that says so.

    Raises:
        ErError: A package of the extra is not installed; the line says how to install it.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        missing = str(error.name).split(".")[0]
        raise ErError(
            f"{use} needs the Python package {missing}: pip install '{wanted}'"
        ) from None

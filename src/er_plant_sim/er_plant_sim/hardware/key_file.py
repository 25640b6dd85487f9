"""``wire_key``: make the key that host and device share, or print it for the firmware. docs/hardware.md.

    ./er run er_plant_sim wire_key             # ~/.config/er/wire.key, for the user alone
    ./er run er_plant_sim wire_key --c FILE    # as an array of C, of a file that is there

Exit status 0; 2 with one line for a file that is there already, or that others can read.
"""

from __future__ import annotations

import argparse
import os
import re
import secrets
import stat
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from er_models.errors import InputError
from er_models.one_line import OneLine

from er_plant_sim.hardware.seal import KEY

NONE: Final = "none"
"""In place of a file: a wire without authentication."""
COMMAND: Final = "er run er_plant_sim wire_key"
OTHERS: Final = stat.S_IRWXG | stat.S_IRWXO
LARGEST: Final = 1024


def default() -> Path:
    """The user's own key file."""
    folder = os.environ.get("XDG_CONFIG_HOME", "")
    base = Path(folder) if folder.startswith("/") else Path.home() / ".config"
    return base / "er" / "wire.key"


def chosen(text: str, kind: str) -> tuple[Path | None, bool]:
    """The file that a parameter means on a wire of this kind, and whether it is made where there is none."""
    if text == NONE or (not text and kind != "udp"):
        return None, False
    return (Path(text), False) if text else (default(), True)


def key_of(text: str, kind: str) -> tuple[bytes, str]:
    """The key for a wire of this kind, empty without authentication; and what the user should know of it.

    text: what the parameter says: a file, `none`, or nothing (over UDP the user's own, made where there is none).

    Raises:
        InputError: A file that is not there, holds no key, or can be read by others.
    """
    path, made = chosen(text, kind)
    if path is None:
        return b"", (
            "a wire without authentication: who can send to it can move the damper (docs/security.md)"
        )
    if made and make(path):
        return read(path), f"made the key {path}: the device needs it, too (docs/hardware.md)"
    return read(path), ""


def read(path: Path) -> bytes:
    """The key in a file.

    Raises:
        InputError: It is not there, holds no key, or can be read by others.
    """
    try:
        with path.open("rb") as file:
            found = os.fstat(file.fileno())
            text = file.read(LARGEST).decode("ascii", "replace").strip()
    except OSError as error:
        raise InputError(path, "", f"a key ({COMMAND})", error.strerror or str(error)) from None
    if found.st_mode & OTHERS:
        mode = f"mode {stat.S_IMODE(found.st_mode):04o}"
        raise InputError(path, "", "a key that only its owner can read (chmod 600)", mode)
    if found.st_uid not in (os.geteuid(), 0):
        raise InputError(path, "", "a key of this user", f"one of user {found.st_uid}")
    if not re.fullmatch(rf"[0-9a-fA-F]{{{2 * KEY}}}", text):
        raise InputError(
            path, "", f"{2 * KEY} hexadecimal digits", f"{len(text)} other characters"
        )
    return bytes.fromhex(text)


def make(path: Path) -> bool:
    """Make a key at random; False where there is a file already, which stays as it is.

    Raises:
        InputError: It cannot be written there.
    """
    unfinished = path.with_name(f".{path.name}.{secrets.token_hex(8)}")
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with open(os.open(unfinished, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600), "w") as file:
            file.write(f"{secrets.token_hex(KEY)}\n")
        try:
            os.link(unfinished, path)  # whole, or not at all, and never over another
        finally:
            unfinished.unlink()
    except FileExistsError:
        return False
    except OSError as error:
        raise InputError(path, "", "a place for a key", error.strerror or str(error)) from None
    return True


def in_c(key: bytes) -> str:
    """The key as C99."""
    rows = [", ".join(f"0x{each:02x}" for each in key[at : at + 8]) for at in range(0, KEY, 8)]
    return f"static const uint8_t er_wire_key[{KEY}] = {{\n    " + ",\n    ".join(rows) + "};"


def main(argv: Sequence[str] | None = None) -> None:
    """Entry point of the executable."""
    p = OneLine(prog="wire_key", description=__doc__, allow_abbrev=False)
    p.formatter_class = argparse.RawDescriptionHelpFormatter
    p.add_argument("file", nargs="?", type=Path, default=default(), help="key file")
    p.add_argument("--c", action="store_true", help="print the key of the file as an array of C")
    options = p.parse_args(argv)
    try:
        if options.c:
            print(in_c(read(options.file)))  # noqa: T201
        elif make(options.file):
            print(f"wire_key: made {options.file}, for this user alone")  # noqa: T201
        else:
            raise InputError(options.file, "", "a file that is not there yet", "a file")
    except InputError as error:
        sys.stderr.write(f"wire_key: {error}\n")
        sys.exit(error.exit_status)


if __name__ == "__main__":
    main()

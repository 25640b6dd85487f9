"""Writes rosbag2 recordings (MCAP or sqlite3) without needing rosbag2.

What is known about the whole recording goes into its custom data when it is closed. Once a second
everything is on disk, so that a recording whose program was killed can still be salvaged. Where the disk refuses,
whatever the storage, an `OSError` says so, and the recording stays as it was brought to disk, without an end.
"""

from __future__ import annotations

import errno
import json
import shutil
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Final

from er_models.errors import InputError
from rosbags.interfaces import Connection, Qos
from rosbags.rosbag2 import StoragePlugin, Writer

from er_records.recording.message_definitions import full_definition

STORAGES = {"mcap": StoragePlugin.MCAP, "sqlite3": StoragePlugin.SQLITE3}
VERSION: Final = 9
"""Version of rosbag2's metadata: that of ROS 2 Jazzy."""


class BagWriter:
    """An open recording.

    Raises:
        InputError: The folder exists already, or cannot be made.
    """

    def __init__(self, out: Path, storage: str = "mcap") -> None:
        if out.exists():
            what = "a folder" if out.is_dir() else "a file"
            raise InputError(out, "", "a path that does not exist yet", f"{what} with that name")
        self.out, self.storage, self.refused = out, storage, False
        self._writer = Writer(out, version=VERSION, storage_plugin=STORAGES[storage])
        try:
            with self._disk():
                self._writer.open()
        except OSError as error:
            shutil.rmtree(out, ignore_errors=True)
            raise InputError(out, "", "a folder that can be made", error.strerror) from None
        self.messages = 0

    def topic(self, name: str, type_name: str, offered: Sequence[Qos] = ()) -> Connection:
        """Announce a topic; offered: the quality of service its publishers offer.

        Raises:
            ErError: There is no definition of the type.
        """
        text, digest = full_definition(type_name)
        with self._disk():
            return self._writer.add_connection(
                name, type_name, msgdef=text, rihs01=digest, offered_qos_profiles=offered
            )

    def write(self, topic: Connection, time: int, data: bytes) -> None:
        """Write a serialized message that was received at time [ns]."""
        with self._disk():
            self._writer.write(topic, time, data)
        self.messages += 1

    def flush(self) -> None:
        """Bring everything written so far to disk."""
        storage: Any = self._writer.storage
        with self._disk():
            if self.storage == "sqlite3":
                storage.conn.commit()
            elif storage.chunk.msgs:
                storage.close_chunk()
                storage.bio.flush()

    def close(self, custom: Mapping[str, object]) -> None:
        """Finish the recording, if the disk has taken all of it; custom: key to text, or to what becomes JSON."""
        if self.refused:
            self._leave()
            return
        for key, value in custom.items():
            text = value if isinstance(value, str) else json.dumps(value, sort_keys=True)
            self._writer.set_custom_data(key, text)
        try:
            with self._disk():
                self._writer.close()
        except OSError:
            self._leave()
            raise

    def discard(self, worthless: int = 0) -> None:
        """Remove a recording without messages, but for that many worthless ones; one with others is never removed."""
        if self.messages > worthless:
            raise ValueError(f"{self.out} holds {self.messages} messages")
        self._leave()
        shutil.rmtree(self.out)

    def _leave(self) -> None:
        """Let go of the files as they are, without what is not whole on disk."""
        with suppress(OSError), self._disk():
            self._writer.abort()

    @contextmanager
    def _disk(self) -> Iterator[None]:
        """What is written in here: where the disk refuses it an `OSError`, also from sqlite."""
        try:
            yield
        except OSError:
            self.refused = True
            raise
        except sqlite3.Error as error:
            self.refused = True
            raise OSError(errno.EIO, str(error)) from None

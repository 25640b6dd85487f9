"""Writes rosbag2 recordings (MCAP or sqlite3) without needing rosbag2.

What is known about the whole recording goes into its custom data when it is closed. Once a second
everything is on disk, so that a recording whose program was killed can still be salvaged.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from er_models.errors import InputError
from rosbags.interfaces import Connection, Qos
from rosbags.rosbag2 import StoragePlugin, Writer

from er_model_lab.message_definitions import full_definition

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
        self.out, self.storage = out, storage
        self._writer = Writer(out, version=VERSION, storage_plugin=STORAGES[storage])
        try:
            self._writer.open()
        except OSError as error:
            raise InputError(out, "", "a folder that can be made", error.strerror) from None
        self.messages = 0

    def topic(self, name: str, type_name: str, offered: Sequence[Qos] = ()) -> Connection:
        """Announce a topic; offered: the quality of service its publishers offer.

        Raises:
            ErError: There is no definition of the type.
        """
        text, digest = full_definition(type_name)
        return self._writer.add_connection(
            name, type_name, msgdef=text, rihs01=digest, offered_qos_profiles=offered
        )

    def write(self, topic: Connection, time: int, data: bytes) -> None:
        """Write a serialized message that was received at time [ns]."""
        self._writer.write(topic, time, data)
        self.messages += 1

    def flush(self) -> None:
        """Bring everything written so far to disk."""
        storage: Any = self._writer.storage
        if self.storage == "sqlite3":
            storage.conn.commit()
        elif storage.chunk.msgs:
            storage.close_chunk()
            storage.bio.flush()

    def close(self, custom: Mapping[str, object]) -> None:
        """Finish the recording; custom: key to text, or to what becomes JSON."""
        for key, value in custom.items():
            text = value if isinstance(value, str) else json.dumps(value, sort_keys=True)
            self._writer.set_custom_data(key, text)
        self._writer.close()

    def discard(self) -> None:
        """Remove a recording without messages; one with messages is never removed."""
        if self.messages:
            raise ValueError(f"{self.out} holds {self.messages} messages")
        self._writer.abort()
        shutil.rmtree(self.out)

"""Settings of the middleware that ROS 2 has no word for, unless the user has a file of his own.

A reliable reader learns what it lacks from the writer's heartbeat: every 3 s in Fast DDS, and with every message once
the writer's history is full. With a history that is deep enough for a recorder that was held up, each reader that
missed one message would wait for up to 3 s, since messages are delivered in order. So it is 0.1 s here.

A process announces itself five times within half a second and then every 3 s: whoever was busy just then waits for the
next time, and a new process may be too new for the first answer to it. Here it is twenty times within 2 s, then every
quarter of a second, which costs less than 0.1 % of a core.

Messages arrive by UDP, also within a machine. At Fast DDS's shared memory a process that was killed is written to for
up to 3 s more, and nobody hears the one that takes its place meanwhile (Fast-DDS pull request 4737); one that is only
held up is taken for dead after a second, and may stay deaf. UDP costs 0.2 ms of a loop through three processes;
four corners take no less processor time through shared memory (docs/results/reliability.md).

After each message to a reliable reader a writer ignores for a while that the reader lacks it. Fast DDS's own while is
zero, kept by a timer of its own thread: every message to every reader woke that thread, which then waited for the very
lock that the publishing loop held. Here it is 20 ms, so that the timer runs on over several messages; three fifths of
a plant's changes of thread are gone. What was lost is sent again with the next heartbeat after it.

Other middlewares do not read the file.
"""

from __future__ import annotations

import os
from collections.abc import MutableMapping
from pathlib import Path

FILE = Path(__file__).with_name("dds.xml")
VARIABLE = "FASTRTPS_DEFAULT_PROFILES_FILE"
OWN = "DEFAULT_FASTRTPS_PROFILES.xml"
"""What Fast DDS reads in the folder where a program is started."""


def settle(env: MutableMapping[str, str] = os.environ, folder: Path = Path()) -> None:
    """Have Fast DDS read our settings; before anything of ROS is made."""
    if VARIABLE not in env and not (folder / OWN).is_file():
        env[VARIABLE] = str(FILE)

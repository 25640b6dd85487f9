"""Gains of a running observer for another model, in a process of its own: ``python -m er_observers.making``.

Whoever asked for them looks now and then and never waits. The process ends with its owner.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from threading import Thread

from er_models.errors import ErError
from er_models.orphan import step_aside, wait_for_owner


class Making:
    """Gains of an observer for a model file that are being made into another file.

    failed: why there are none, empty while it works and where there are.
    """

    def __init__(self, observer: str, model: str, gains: str, *, leave_out: bool) -> None:
        self.failed, self._said = "", b""
        words = [observer, model, gains, *(["leave-out"] if leave_out else [])]
        command = [sys.executable, "-m", "er_observers.making", *words]
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, start_new_session=True)
        os.set_blocking(self._process.stdout.fileno(), False)  # type: ignore[union-attr]

    def look(self) -> bool:
        """Whether it has ended. Never waits."""
        process = self._process
        if process.stdout is None or process.stdin is None:
            return True
        status = process.poll()  # before the last look: what it said then is all
        self._said += process.stdout.read() or b""
        if status is None:
            return False
        if status:
            said = " ".join(self._said.decode(errors="replace").split())
            self.failed = said or f"the process ended with status {status}"
        process.stdin.close()
        process.stdout.close()
        return True

    def stop(self) -> None:
        """End it now: its owner ends, or wants others."""
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        self.look()


def beside(model: str, observer: str) -> str:
    """Where the gains of an observer for a model file are put."""
    path = Path(model).absolute()
    return str(path.with_name(f"{path.stem}_{observer}.yaml"))


def _end_with_owner() -> None:
    wait_for_owner()
    os._exit(1)


def main() -> None:
    """Make, prove and write the gains, or say why there are none."""
    from er_observers.gains import save_gains
    from er_observers.held import held
    from er_observers.synthesis.make import synthesise

    step_aside()
    Thread(target=_end_with_owner, daemon=True).start()
    observer, file, out, *more = sys.argv[1:]
    try:
        model, _ = held(file, leave_out=bool(more))
        save_gains(out, observer, model, *synthesise(observer, model))
    except ErError as error:
        sys.stdout.write(str(error))
        sys.exit(error.exit_status)


if __name__ == "__main__":
    main()

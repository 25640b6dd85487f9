"""The node around an observer: asked for a model without gains, it has them made and goes over when they are proved.

Making them takes seconds, proving them again a tenth of one: neither is the loop's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from threading import Thread
from typing import cast

from er_common.program import Program
from er_models.errors import ErError
from er_ros_common.core_node import LATER, CoreNode
from rclpy.parameter import Parameter

from er_observers.held import held
from er_observers.making import Making, beside
from er_observers.ros_observer import ObserverCore, files
from er_observers.settings import ObserverParameters
from er_ros_common import log

LOOK = 0.1
"""How often the process that makes gains is looked at [s]."""


class Loading:
    """A core with other files that a thread makes; core: None until it is there; failed: why there is none."""

    def __init__(self, before: ObserverCore, p: ObserverParameters) -> None:
        self.core: ObserverCore | None = None
        self.failed = ""
        self._before, self._p = before, p
        self._thread = Thread(target=self._make, daemon=True)
        self._thread.start()

    def _make(self) -> None:
        try:
            self.core = self._before.tuned(self._p)
        except ErError as error:
            self.failed = str(error)

    def look(self) -> bool:
        """Whether it has ended. Never waits."""
        return not self._thread.is_alive()


class ObserverNode(CoreNode):
    """An observer, the gains that are being made for it, and the core that is being made of them.

    wish: its parameters with the files that it is to go over to.
    """

    core: ObserverCore
    p: ObserverParameters

    def __init__(self, program: Program, argv: Sequence[str] | None = None) -> None:
        super().__init__(program, argv)
        self.making: Making | None = None
        self.loading: Loading | None = None
        self.wish: ObserverParameters = self.p

    def configure(self) -> None:
        """The core, and a look at what is being made."""
        super().configure()
        self.every(LOOK, self.on_look)

    def tune(self, p: ObserverParameters) -> None:
        """Go over to other files, at once where they are loaded; without gains, have them made."""
        if not p.gains_file:
            raise ErError(self._begin(p))
        loaded = self.loading.core if self.loading else None
        if loaded is not None and files(loaded.p) == files(p):
            self.go_over(loaded.tuned(p))
        else:
            super().tune(p)
            if files(p) != files(self.p):
                self._give_up()

    def _begin(self, p: ObserverParameters) -> str:
        """Have gains made for a model; what is said of it. Raises `ErError` where the model cannot be used."""
        model, left_out = held(p.model_file, leave_out=p.leave_out)
        self._give_up()
        name, file = self.core.name, str(Path(p.model_file).absolute())
        self.wish = replace(p, model_file=file, gains_file=beside(file, name))
        self.making = Making(name, file, self.wish.gains_file, leave_out=p.leave_out)
        without = (
            f" without {', '.join(left_out)}, which its form cannot hold," if left_out else ""
        )
        said = f"gains for {model.name}{without} are being made: {LATER}"
        log.info(self, said)
        return said

    def on_look(self) -> None:
        """Go on with what is being made."""
        making, loading = self.making, self.loading
        if making is not None and making.look():
            self.making = None
            if making.failed:
                log.warning(self, f"no gains, the model stays: {making.failed}")
            else:
                self.loading = Loading(self.core, self.wish)
        elif loading is not None and loading.look():
            why = loading.failed or self._set(cast(ObserverCore, loading.core).p)
            self.loading = None
            if why:
                log.warning(self, f"the model stays: {why}")

    def _set(self, p: ObserverParameters) -> str:
        """Set this node's own parameters, as anybody may; why not, empty where it was done."""
        given = {"model_file": p.model_file, "gains_file": p.gains_file, "leave_out": p.leave_out}
        made = [Parameter(name, value=value) for name, value in given.items()]
        return str(self.set_parameters_atomically(made).reason)

    def _give_up(self) -> None:
        if self.making is not None:
            self.making.stop()
        self.making = self.loading = None

    def end(self) -> None:
        """Make no more."""
        super().end()
        self._give_up()


AROUND = ObserverNode

"""``er synth``: gains of observers, and of the LPV controller by its name."""

from __future__ import annotations

import sys

CONTROLLER = "lpv_ftc"


def main() -> None:
    """Hand the arguments to the package that knows the design they name."""
    if sys.argv[1:2] == [CONTROLLER]:
        from er_ftc_controller.synth import main as controller

        controller(sys.argv[2:])
        return
    from er_observers.synth import main as observers

    if sys.argv[1:2] in ([], ["--help"]):
        print(f"er synth {CONTROLLER} --help: the LPV controller; all else: observers")  # noqa: T201
    observers()


if __name__ == "__main__":
    main()

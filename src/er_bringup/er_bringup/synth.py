"""``er synth``: gains of observers, and of controllers by their names."""

from __future__ import annotations

import sys
from importlib import import_module

CONTROLLERS = {
    "lpv_ftc": "er_ftc_controller.synth",
    "body_lqr": "er_ftc_controller.body_synth",
}
"""Names of controllers, and the module that makes the gains of each."""


def main() -> None:
    """Hand the arguments to the package that knows the design they name."""
    if (found := CONTROLLERS.get("".join(sys.argv[1:2]))) is not None:
        import_module(found).main(sys.argv[2:])
        return
    from er_observers.synth import main as observers

    if sys.argv[1:2] in ([], ["--help"]):
        for name in CONTROLLERS:
            print(f"er synth {name} --help: a controller")  # noqa: T201
    observers()


if __name__ == "__main__":
    main()

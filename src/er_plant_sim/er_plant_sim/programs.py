"""The programs of the package, each declared here and nowhere else."""

from __future__ import annotations

from typing import Final

from er_common.program import Program

PACKAGE = "er_plant_sim"
PLANT: Final = Program(
    "plant", PACKAGE, "A quarter car with a semi-active damper, measured at every tick."
)
BRIDGE: Final = Program(
    "hardware_bridge",
    PACKAGE,
    "A real rig behind a serial port or UDP, with the topics of the plant: docs/hardware.md.",
)
CAR: Final = Program(
    "car_plant", PACKAGE, "A whole car: four corners below one body, measured at every tick."
)
EMULATOR: Final = Program(
    "device_emulator", PACKAGE, "A rig that is only a program.", module="hardware.emulator"
)
WIRE_KEY: Final = Program(
    "wire_key", PACKAGE, "The key that host and device share.", module="hardware.key_file"
)
PROGRAMS: Final = (PLANT, BRIDGE, CAR, EMULATOR, WIRE_KEY)

"""Entry points of the package's nodes, light: see `er_ros_common.entry`."""

from er_ros_common.entry import program

plant = program("er_plant_sim.nodes.plant")
hardware_bridge = program("er_plant_sim.nodes.hardware_bridge")
device_emulator = program("er_plant_sim.hardware.emulator")

"""Blow-off valves, worked by hand."""

from worked import PASSIVE, Force

VALVES = {"c_e": 100.0, "v_e": 0.1, "c_c": -50.0, "v_c": 0.05, "v_w": 0.05}
WORKED = (
    # 100 (0.1 m/s)^2 / 0.15 m/s
    Force(VALVES, v=0.2, force=20.0 / 3.0),
    # 50 (0.05 m/s)^2 / 0.1 m/s
    Force(VALVES, v=-0.1, force=1.25),
    # both shut: 50 Ns/m alone
    Force(VALVES, PASSIVE, v=-0.04, force=-2.0),
)
SHOWN = {"c_e": 60.0, "v_e": 0.04, "c_c": -40.0, "v_c": 0.06}

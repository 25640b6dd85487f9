"""Passive stiffness and viscosity by direction, worked by hand."""

from worked import Force, Stroke

WORKED = (
    # release
    Force(
        {"k0_c": 300.0, "c0_c": 20.0, "k0_r": 100.0, "c0_r": 50.0, "v_0": 1e-3},
        x=0.01,
        v=0.1,
        force=6.0,
    ),
    # in series: release: as above
    Force(
        {"k0_c": 300.0, "c0_c": 20.0, "k0_r": 100.0, "c0_r": 50.0, "v_0": 1e-3},
        {"mount_compliance": {"q": 0.01}},
        x=0.01,
        v=0.1,
        force=3.0,
    ),
    # cavitation: a void of 0.05 s 1 N / 50 Ns/m = w_s: half of 1 N lacks at 0.5 + 5 N
    Stroke(
        {"k0_c": 300.0, "c0_c": 20.0, "k0_r": 100.0, "c0_r": 50.0, "v_0": 1e-3},
        {"cavitation": {"F_v": 4.0, "r": 0.0, "w_s": 1e-3}},
        v=0.1,
        force=5.0,
    ),
)

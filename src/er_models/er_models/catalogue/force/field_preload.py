"""Force in proportion to the field: F_u u_f, moving or not."""

from er_models.effect import Effect, Param, Signature


def force(F_u: float, u_f: float) -> float:
    """Force that follows the field [N]."""
    return F_u * u_f


EFFECT = Effect(
    name="field_preload",
    stage="force",
    title="Preload that grows with the field",
    physics="A pressure on an area pushes the rod, at rest as in motion: that of a pneumatic or hydraulic supply, or "
    "the normal stress of a fluid under field. The force follows the duty with the response time of the damper.",
    parameters=(Param("F_u", "N/duty", -10.0, 10.0, 0.0, (0.1,), "force per duty"),),
    hooks={"force": force},
    signature=Signature(
        mark="a force in proportion to the duty, of one sign, at standstill too",
        plane="force-duty",
        experiment="several duties at standstill in the middle of the stroke",
        rivals=("preload", "deflection_zero", "field_stiffness"),
        needs=("duty_levels",),
    ),
    source="Belforte, Raparelli and Mazza 1992 (pneumatic cylinder: pressure times area); Laun, Gabriel and Schmidt "
    "2008 (normal stress of a fluid under field)",
)

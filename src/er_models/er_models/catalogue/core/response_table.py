"""Response time tabulated over five equally spaced duties (Table 1.4): linear in between, held at the ends."""

from er_models.effect import Effect, Param, Signature


def response_time(
    u_1: float, d_u: float, tau_1: float, tau_2: float, tau_3: float, tau_4: float, tau_5: float,
    u: float,
) -> float:  # fmt: skip
    """Response time at this duty [s]."""
    place = (u - u_1) / d_u
    second = (tau_2 - tau_1) * min(max(place, 0.0), 1.0)
    third = (tau_3 - tau_2) * min(max(place - 1.0, 0.0), 1.0)
    fourth = (tau_4 - tau_3) * min(max(place - 2.0, 0.0), 1.0)
    return tau_1 + second + third + fourth + (tau_5 - tau_4) * min(max(place - 3.0, 0.0), 1.0)


EFFECT = Effect(
    name="response_table",
    stage="core",
    title="Response time, tabulated over the duty",
    physics="Response times as measured at five duties, linear between them and held outside: below the "
    "first and above the last duty nothing was measured. Each value needs data near its duty. Takes the place "
    "of the constant response time; the lag itself is that of `response`.",
    parameters=(
        Param(
            "u_1", "duty", 0.0, 3.0, None, (1.0 / 3.0,), "first duty of the table", fitted=False
        ),
        Param(
            "d_u", "duty", 0.01, 3.0, None, (1.0 / 6.0,), "distance of the duties", fitted=False
        ),
        Param("tau_1", "s", 0.0, 1.0, 0.0, (0.01, 0.03), "response time at u_1"),
        Param("tau_2", "s", 0.0, 1.0, 0.0, (0.02, 0.03), "response time at u_1 + d_u"),
        Param("tau_3", "s", 0.0, 1.0, 0.0, (0.03, 0.03), "response time at u_1 + 2 d_u"),
        Param("tau_4", "s", 0.0, 1.0, 0.0, (0.04, 0.03), "response time at u_1 + 3 d_u"),
        Param("tau_5", "s", 0.0, 1.0, 0.0, (0.05, 0.03), "response time at u_1 + 4 d_u"),
    ),
    hooks={"response_time": response_time},
    signature=Signature(
        mark="the lag of the force grows with the duty within the table and not beyond it",
        plane="time",
        experiment="large slow sine with square waves of duty of different height",
        rivals=("varying_time_constant", "response_quadratic"),
    ),
    source="thesis Table 1.4 (0.0137, 0.0221, 0.0365, 0.055, 0.0631 s at duty 0.1 to 0.3)",
)

"""Certificates and scores as tables for people."""

from __future__ import annotations

from collections.abc import Sequence

from rich.table import Table

from er_observers.observers.kernel import SUBSTEP
from er_observers.running.evaluate import Score
from er_observers.synthesis.certify import Certificate
from er_observers.synthesis.proof import Claim


def certificate_table(title: str, claim: Claim, c: Certificate) -> Table:
    """The certificate for people."""
    s, spec, peak = claim.solution, claim.spec, c.peak
    table = Table(title=title, title_justify="left")
    table.add_column("statement")
    table.add_column("value", justify="right")
    table.add_column("shown by")
    at = f"{peak.omega:.3g} rad/s, duty {peak.rho:.2f}, slope {peak.slope:g}"
    where = f"grid, substeps of {1e3 * SUBSTEP:.4g} ms, duty {c.run.rho:.2f}"
    rows = f"farthest from the law, {len(c.table.duties)} duties"
    lines = [
        ("gamma, to the force", f"{s.gamma:.4f}", f"inequalities; optimum {s.optimum:.4f}"),
        ("gain, frozen gate", f"{peak.gain:.4f}", f"sweep: {at}"),
        ("gain, any slope", f"{c.slopes:.4f}", "one P for slopes 0 and 1: a second method"),
        ("smallest margin", f"{c.margins.smallest:.1e}", "eigenvalues; half of it in fractions"),
        *(
            (f"poles, duty {rho:g} [1/s]", _poles(end), f"disc of {spec.radius:g}")
            for rho, end in zip(spec.rho, (c.poles[0], c.poles[-1]), strict=True)
        ),
        ("slowest pole [1/s]", f"{c.slowest:.3f}", "any duty and slope; before yield"),
        ("discrete decay [1/s]", f"{c.run.decay:.3f}", where),
        ("table of substeps", f"{c.table.gap:.1e}", rows),
        ("growth per sample", f"{c.wandering:.5f}", "compiled observer, random duties"),
    ]
    for line in lines:
        table.add_row(*line)
    return table


def score_table(scores: Sequence[Score]) -> Table:
    """Errors per scenario for people."""
    table = Table(title="force error from the true force of the simulated plant")
    table.add_column("scenario")
    for name in ("NRMSE [%]", "rms [N]", "largest [N]", "first OK [s]", "WEAK [%]", "ratio"):
        table.add_column(name, justify="right")
    for s in scores:
        first = "never" if s.first_ok is None else f"{s.first_ok:.2f}"
        numbers = (f"{100 * s.nrmse:.2f}", f"{s.rmse:.3f}", f"{s.largest:.2f}", first)
        table.add_row(s.scenario, *numbers, f"{100 * s.weak:.0f}", f"{s.test_ratio:.2f}")
    return table


def _poles(poles: Sequence[complex]) -> str:
    """Poles, a pair once."""
    texts = [
        f"{p.real:.1f}" if p.imag == 0.0 else f"{p.real:.1f}±{p.imag:.1f}j"
        for p in poles
        if p.imag >= 0.0
    ]
    return "\n".join(texts)

"""What the words of the lab mean, in a sentence each: the one table that the page's help is read from."""

from __future__ import annotations

TERMS: dict[str, str] = {
    "learnt from": "Root mean square error on the data that values are fitted to.",
    "held out": "Data that no fit and no choice of an effect has seen: they only score. An error that falls there "
    "is no adaptation to chance.",
    "residual": "Measured less predicted force: what the model leaves.",
    "residual map": "Rms of the residual over velocity and deflection; a dark tile is where the model fails.",
    "spectrum": "Amplitude density of the residual over frequency: a peak is something periodic that the model lacks.",
    "worst places": "Seconds and tiles that carry most of the squared error, with their share of it.",
    "findings": "What the check of the data found: failures make a result worthless, warnings weaken it, notes are "
    "good to know.",
    "noise floor": "Error on held-out data that no model of these inputs could fall below; what is left above it can "
    "be explained.",
    "effect size": "Root of the fall of the mean square error on blocks left out, beside what chance alone reaches.",
    "p value": "Probability that chance alone makes an effect look as large in a complete model.",
    "status": "Present: it is there. Absent: it is not. Not excited: these data could not show it. Confounded: they "
    "show that one of several is there, not which.",
    "signature": "The force that an effect adds, over the plane in which it shows, on what your model leaves.",
    "rivals": "Effects whose signature looks alike; a planned run shows which of them is there.",
    "measured term": "A smooth curve over measured quantities, learnt where no effect explains.",
    "waterfall": "The error of the model as given and after every effect that was added, one bar each.",
    "deviation": "Standard deviation of a fitted value, behind \N{PLUS-MINUS SIGN}.",
    "separation": "What the best imitation by the rival leaves, over the noise.",
    "expected power": "How often simulated measurements of the planned run name the effect that is true.",
    "coverage": "How much the drive has shown of what each effect needs; one that nothing excites cannot be told from "
    "one that is not there.",
    "test of its limit": "The sequential test of the running model, over the value at which it raises the alarm.",
    "usual": "The error that the monitor takes for normal, learnt while the model still explained.",
}  # fmt: skip
"""Word to sentence."""

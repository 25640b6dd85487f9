"""How large an effect appears by chance when the model is complete.

The fitted model is taken as the truth along motions that the sensors may have meant, and the force gets noise
of the size and colour that the best model leaves. Every effect of the catalogue, from each of its starts and
where it was fitted, is then added along the fused motion in a straight line and cross-validated over the same
blocks. The largest effect size over the catalogue is recorded (Westfall and Young 1993), so that asking thirty
questions costs nothing. Beyond what few replicates resolve, the squared size falls exponentially (peaks over a
threshold, Pickands 1975); its mean is known from few peaks only, and what another one exceeds follows from F.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from er_models.model import Array

from er_model_lab.diagnosis.candidates import Candidate
from er_model_lab.diagnosis.chance_gain import largest
from er_model_lab.diagnosis.leftover_structure import burst_shares
from er_model_lab.motion.white_noise import white_noise
from er_model_lab.problem.forward import colour_of
from er_model_lab.problem.problem import Problem

MOTIONS = 6
"""Draws of the motion; each serves many draws of the force noise."""
CREDIBLE = 3.0
"""Multiple of what the best rival leaves up to which a model is believed in what the motion sensors cause beside it."""
PEAKS = 12
"""Largest replicates from which the tail is drawn on."""


@dataclass(frozen=True)
class Null:
    """Largest effect sizes [N] by chance, one per replicate.

    input_error: force error [N] that the motion sensors cause on the training samples; force_noise [N] with its
    lag-one correlation `colour`; input_square (n,): mean square [N2] over the draws of the motion, of `outputs` rows
    a sample; bursts: the largest share of the power that lay in bursts, of each output; least: size [N] below which
    nothing is believed, however rare. It is all that the motion sensors cause where the motion repeats itself, since
    that comes back in every cycle, and where it was made without accelerations: the force of the field bends the motion
    at each reversal, fusion rounds the bend off, and by the same law each time, which no draw of noise does.
    """

    maxima: Array
    input_error: float
    force_noise: float
    colour: float
    input_square: Array
    outputs: int = 1
    least: float = 0.0
    bursts: tuple[float, ...] = (0.0,)

    def _peaks(self) -> int:
        """Replicates from which the tail is drawn on."""
        return min(PEAKS, int(np.sum(self.maxima > 0.0)))

    def _tail(self) -> tuple[float, float, float]:
        """Size where the tail begins [N], mean of the squares beyond it [N2], and its probability."""
        order, k = np.sort(self.maxima), self._peaks()
        begin = float(order[-k - 1]) if k < order.size else 0.0
        excess = float(np.mean(order[-k:] ** 2 - begin**2)) if k else 0.0
        return begin, excess, k / max(order.size, 1)

    def threshold(self, false_alarm: float) -> float:
        """Effect size from which on an effect is believed [N]."""
        return max(self.least, self.chance(false_alarm))

    def chance(self, false_alarm: float) -> float:
        """Effect size that noise passes with this probability in a complete model [N]."""
        if not self.maxima.size:
            return 0.0
        begin, mean, share = self._tail()
        if false_alarm >= share:
            return float(np.quantile(self.maxima, 1.0 - false_alarm))
        beyond = self._peaks() * ((share / false_alarm) ** (1.0 / self._peaks()) - 1.0)
        return float(np.sqrt(begin**2 + mean * beyond))

    def p_value(self, size: float) -> float:
        """Probability that chance alone does as well in a complete model."""
        if size <= self.least:
            return 1.0
        begin, mean, share = self._tail()
        if size <= begin or mean <= 0.0:
            return float((1 + np.sum(self.maxima >= size)) / (self.maxima.size + 1))
        beyond = (size**2 - begin**2) / (mean * self._peaks())
        return float(share * (1.0 + beyond) ** -self._peaks())


def simulate_null(
    base: Candidate, rivals: list[Candidate], problem: Problem, seed: int, replicates: int = 64
) -> Null:
    """Replicates of `problem` under the fitted model, scored for every rival."""
    rng = np.random.default_rng(seed)
    wobble = problem.forward.input_errors(problem, base.fit.model, rng, MOTIONS)
    input_error = float(np.sqrt(np.mean(wobble[:, problem.train] ** 2)))
    leader = rivals[0] if rivals else base
    noise, colour = _force_noise(leader, problem, input_error)
    square, outputs = np.mean(wobble**2, axis=0), problem.forward.outputs
    # what the sensors cause at random no effect takes away: the best rival still leaves it
    believed = min(input_error, CREDIBLE * float(np.sqrt(leader.mse)))
    least = believed if problem.cycles or problem.rounded else 0.0
    many = -(-replicates // MOTIONS)
    errors = np.repeat(wobble, many, axis=0) + problem.forward.output_errors(
        leader.fit.residual, noise, colour, rng, many * MOTIONS
    )
    loud = tuple(
        float(burst_shares(part, errors[:, c::outputs], square[c::outputs]).max())
        for c, part in enumerate(problem.parts)
    )
    maxima = largest(base, rivals, problem, errors.T) if rivals else np.zeros(0)
    return Null(maxima, input_error, noise, colour, square, outputs, least, loud)


def _force_noise(best: Candidate, problem: Problem, input_error: float) -> tuple[float, float]:
    """Size [N] and lag-one correlation of the force noise, from what the best rival leaves."""
    r = best.fit.residual[problem.train]
    left = float(np.mean(r**2)) - input_error**2
    size = float(np.sqrt(max(left, white_noise([r]) ** 2, 1e-24)))
    return size, float(np.clip(colour_of(r), 0.0, 0.5))

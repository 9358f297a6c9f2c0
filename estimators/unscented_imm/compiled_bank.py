"""The interacting multiple model, compiled, for all wheels at once; equations in `reference`, which it equals.

A sample that is missing for a wheel moves its filters on and leaves its modes to the transition matrix alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled, inlined
from estimators.unscented_imm.kernel import predict, quarter_of, secured, update
from estimators.unscented_imm.settings import Settings


@inlined
def _steps(
    n, quarters, dt, phi, added, start, start_variance, noise, transition, weights, reach, road_before, road, measured,
    x, P, mu, mean, variance, probability,
):  # fmt: skip
    """Steps all wheels through measured (steps, wheels, 2); x, P, mu, road_before move on; the number of repairs.

    mean, variance (steps, wheels, n) of the mixture and probability (steps, wheels, modes) are written. road (steps,
    wheels, modes) [m]: not looked at where it is a state.
    """
    steps, wheels, _ = measured.shape
    modes = mu.shape[1]
    mixed_x, mixed_P = np.empty((modes, n)), np.empty((modes, n, n))
    L, points, felt, cross = np.zeros((n, n)), np.empty((2 * n + 1, n)), np.empty((2 * n + 1, 2)), np.empty((n, 2))
    predicted, log_mu = np.empty(modes), np.empty(modes)
    repairs = 0
    for t in range(steps):
        for w in range(wheels):
            for j in range(modes):
                predicted[j] = 0.0
                for i in range(modes):
                    predicted[j] += transition[i, j] * mu[w, i]
            for j in range(modes):
                mix(x[w], P[w], mu[w], transition, j, predicted[j], mixed_x[j], mixed_P[j], modes, n)
            highest = -np.inf
            for j in range(modes):
                xj, Pj, q = x[w, j], P[w, j], quarter_of(quarters[w, j])
                xj[:] = mixed_x[j]
                Pj[:] = mixed_P[j]
                repairs += secured(xj, Pj, L, start, start_variance, n)
                predict(
                    q, phi[j], added[j], dt, road_before[w, j], xj, Pj, L, points, weights[0], weights[1], reach, n
                )  # fmt: skip
                repairs += secured(xj, Pj, L, start, start_variance, n)
                likelihood = update(
                    q, road[t, w, j], measured[t, w], noise, xj, Pj, L, points, felt, cross, weights[0], weights[1],
                    reach, n,
                )  # fmt: skip
                repairs += secured(xj, Pj, L, start, start_variance, n)
                if not math.isfinite(likelihood):
                    likelihood, repairs = 0.0, repairs + 1
                log_mu[j] = likelihood + (math.log(predicted[j]) if predicted[j] > 0.0 else -np.inf)
                highest = max(highest, log_mu[j])
                road_before[w, j] = road[t, w, j]
            total = 0.0
            for j in range(modes):
                mu[w, j] = math.exp(log_mu[j] - highest)
                total += mu[w, j]
            for j in range(modes):
                mu[w, j] /= total
                probability[t, w, j] = mu[w, j]
            blend(x[w], P[w], mu[w], mean[t, w], variance[t, w], modes, n)
    return repairs


@inlined
def mix(x, P, mu, transition, j, predicted, mixed_x, mixed_P, modes, n):
    """Mode j's start: mean and lower covariance of the modes that may have become it."""
    mixed_x[:] = 0.0
    mixed_P[:] = 0.0
    if predicted <= 0.0:  # a mode that cannot be entered: it goes on by itself
        mixed_x[:] = x[j]
        mixed_P[:] = P[j]
        return
    for i in range(modes):
        share = transition[i, j] * mu[i] / predicted
        for a in range(n):
            mixed_x[a] += share * x[i, a]
    for i in range(modes):
        share = transition[i, j] * mu[i] / predicted
        if share == 0.0:
            continue
        for a in range(n):
            off = share * (x[i, a] - mixed_x[a])
            for b in range(a + 1):
                mixed_P[a, b] += share * P[i, a, b] + off * (x[i, b] - mixed_x[b])


@inlined
def blend(x, P, mu, mean, variance, modes, n):
    """Mean and variances of the modes' mixture."""
    for a in range(n):
        mean[a] = 0.0
        for j in range(modes):
            mean[a] += mu[j] * x[j, a]
        variance[a] = 0.0
        for j in range(modes):
            variance[a] += mu[j] * (P[j, a, a] + (x[j, a] - mean[a]) ** 2)


# the number of states as a constant, so that LLVM unrolls the small loops: half the time
@compiled
def run_known(*arguments):
    """Five states, the road given."""
    return _steps(5, *arguments)


@compiled
def run_state(*arguments):
    """Six states, the road among them."""
    return _steps(6, *arguments)


@dataclass(frozen=True, eq=False)
class Course:
    """mean, variance of the mixture (steps, wheels, n); probability of the modes (steps, wheels, modes)."""

    mean: NDArray[np.float64]
    variance: NDArray[np.float64]
    probability: NDArray[np.float64]


class CompiledImm:
    """A bank for as many wheels as its settings have. x (wheels, modes, n); P the same with lower triangles; mu."""

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        wheels, modes, _ = settings.quarters.shape
        n = settings.size
        self.x = np.tile(settings.start, (wheels, modes, 1))
        self.P = np.tile(np.diag(settings.start_variance), (wheels, modes, 1, 1))
        self.mu = np.full((wheels, modes), 1.0 / modes)
        self.repairs = 0
        """How often a state or a covariance had to be made usable."""
        self._weights = np.full((2, 2 * n + 1), 0.5 / n)
        self._weights[:, 0] = 0.0
        self._road: NDArray[np.float64] | None = None

    def run(self, measured: NDArray[np.float64], road: NDArray[np.float64] | None = None) -> Course:
        """Samples [a_s, a_us] [m/s^2], shape (steps, wheels, 2), NaN where missing; road: heights that each mode is
        given [m], (steps, wheels, modes), None where it is a state. ValueError where it is wanted and not given, or not
        finite."""
        s = self._settings
        (wheels, modes), n, steps = self.mu.shape, s.size, len(measured)
        if n == 5 and road is None:
            raise ValueError("road: want the heights that the modes are given")
        if road is not None and not np.isfinite(road).all():
            raise ValueError("road: heights must be finite")
        given = np.zeros((steps, wheels, modes)) if road is None else np.ascontiguousarray(road, dtype=float)
        if self._road is None:
            self._road = given[0].copy() if steps else np.zeros((wheels, modes))
        course = Course(np.empty((steps, wheels, n)), np.empty((steps, wheels, n)), np.empty((steps, wheels, modes)))
        run = run_known if n == 5 else run_state
        self.repairs += run(
            s.quarters, s.step, s.phi, s.wander, s.start, s.start_variance, s.measured_variance, s.transition,
            self._weights, math.sqrt(n), self._road, given, np.ascontiguousarray(measured, dtype=float), self.x, self.P,
            self.mu, course.mean, course.variance, course.probability,
        )  # fmt: skip
        return course

    def covariance(self, wheel: int, mode: int) -> NDArray[np.float64]:
        """P of one mode, both triangles, (n, n)."""
        low = np.tril(self.P[wheel, mode])
        return low + np.tril(low, -1).T

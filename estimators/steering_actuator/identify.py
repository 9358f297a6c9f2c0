"""The servo model from fault-free drives: least squares of what it does not foresee of the motor's angle.

Prediction errors of an output-error model with an autoregression for its noise (Ljung, System Identification, 2nd ed.,
4.2, 7.2): the output error is minimised over the model (least squares over logarithms from the best of a grid, then a
simplex, since delay, gain and zero lie in a narrow valley; first of the linear servo and its two limits, then of all);
the autoregression and the spread are then fitted to what
is left (`watch.fitted`). The limits are told by the drives that reach them; one that none reaches is set beyond.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares, minimize

from estimators.steering_actuator.servo_model import LONGEST_DELAY, ServoModel, simulated

GAINS, RATIOS, ZEROS = (8.0, 20.0, 40.0, 80.0, 160.0), (3.0, 8.0), (1e-3, 0.9)  # p [1/s], q / p, f to begin with
HARDEST = (0.5, 1.0)  # of the largest acceleration that is seen
STARTS, STEPS, POLISH = 3, 30, 200  # Gauss-Newton steps of a start, simulations of the simplex
LIMITS = (4, 5, 7, 8)
NEVER_BINDS, FREE = 10.0, 1e-3  # a limit so many times higher that makes the errors worse by less than a share of FREE
# p, q, f, delay, w_max, a_max, r, a_0, w_0, c; q: so that SUBSTEP resolves it
_LOWEST = np.log(np.array([0.1, 0.5, 1e-4, 1e-5, 0.01, 0.1, 1e-3, 1.0, 1.0, 1e-2]))
_HIGHEST = np.log(np.array([1e3, 900.0, 3.0, LONGEST_DELAY, 1e4, 1e6, 300.0, 1e7, 1e5, 1e4]))
FEW = 6  # numbers of the first fit
INTEGRALS, RUBS = (5.0, 40.0), (0.01, 0.05)  # r, c of the largest acceleration that is seen, to begin the second with

Array = NDArray[np.float64]


def linear_servo(demands: Sequence[Array], angles: Sequence[Array]) -> ServoModel:
    """p, q, f, delay and the two limits alone. demands, angles: of drives, each (n,) [rad of motor], a row each cell,
    NaN where missing. ValueError for drives in which the motor does not move."""
    speed, push = _largest(angles)
    cost = _cost(demands, angles)
    low, high = _LOWEST[:FEW], _HIGHEST[:FEW]
    first = [
        np.clip(np.log([p, min(p * r, 800.0), f, 2e-3, speed, share * push]), low + 1e-6, high - 1e-6)
        for p in GAINS for r in RATIOS for f in ZEROS for share in HARDEST
    ]  # fmt: skip
    fits = [_fit(start, demands, angles) for start in sorted(first, key=cost)[:STARTS]]
    return _model(_freed(_polished(min(fits, key=cost), cost), LIMITS[:2], cost))


def identified(demands: Sequence[Array], angles: Sequence[Array]) -> ServoModel:
    """All numbers; arguments and errors as `linear_servo`."""
    simple = np.log(np.maximum(linear_servo(demands, angles)[:FEW], 1e-12))
    (speed, push), cost = _largest(angles), _cost(demands, angles)
    free = 1.2 * np.exp(min(simple[4], np.log(speed)))
    more = [np.log([r, 4.0 * np.exp(simple[5]), free, c * push]) for r in INTEGRALS for c in RUBS]
    fits = [_fit(np.concatenate([simple, start]), demands, angles) for start in more]
    best = _freed(_polished(min(fits, key=cost), cost), LIMITS, cost)
    return _model(min((simple, best), key=cost))


def _cost(demands: Sequence[Array], angles: Sequence[Array]) -> Callable[[Array], float]:
    return lambda logs: float(np.sum(_errors(logs, demands, angles) ** 2))


def _freed(best: Array, limits: Sequence[int], cost: Callable[[Array], float]) -> Array:
    """With limits that no drive reaches beyond reach."""
    for limit in limits:
        freed = best.copy()
        freed[limit] = min(best[limit] + np.log(NEVER_BINDS), _HIGHEST[limit])
        best = freed if cost(freed) < (1.0 + FREE) * cost(best) else best
    return best


def _fit(start: Array, demands: Sequence[Array], angles: Sequence[Array]) -> Array:
    low, high = _LOWEST[: len(start)], _HIGHEST[: len(start)]
    return least_squares(
        lambda z: _errors(z, demands, angles), np.clip(start, low + 1e-6, high - 1e-6), bounds=(low, high),
        diff_step=1e-3, x_scale=0.3, max_nfev=STEPS,
    ).x  # fmt: skip


def _polished(start: Array, cost: Callable[[Array], float]) -> Array:
    bounds = list(zip(_LOWEST[: len(start)], _HIGHEST[: len(start)], strict=True))
    options = {"maxfev": POLISH, "initial_simplex": _simplex(start), "adaptive": True}
    return minimize(cost, start, method="Nelder-Mead", bounds=bounds, options=options).x


def _simplex(centre: Array) -> Array:
    return np.vstack([centre, centre + np.diag(np.full(len(centre), 0.1))])


def _model(logs: Array) -> ServoModel:
    return ServoModel(*np.exp(logs).tolist())


def _errors(logs: Array, demands: Sequence[Array], angles: Sequence[Array]) -> Array:
    model = _model(logs)
    parts = [angle - simulated(model, demand)[:, 0] for demand, angle in zip(demands, angles, strict=True)]
    left = np.concatenate(parts)
    return np.where(np.isfinite(left), np.clip(left, -1e3, 1e3), 0.0)


def _largest(angles: Sequence[Array]) -> tuple[float, float]:
    """Speed and acceleration that the motor reached, over 50 ms."""
    speeds, pushes = [0.0], [0.0]
    for angle in angles:
        steps = np.diff(angle, n=1)[2:]
        mean = np.convolve(steps, np.full(5, 0.2 / 0.01), "valid")
        if len(mean) > 6:
            speeds.append(float(np.nanmax(np.abs(mean), initial=0.0)))
            pushes.append(float(np.nanmax(np.abs(mean[5:] - mean[:-5]), initial=0.0)) / 0.05)
    if not max(speeds) > 1e-3:
        raise ValueError("the motor does not move in any drive, want drives in which it follows its demand")
    return 1.05 * max(speeds), 2.0 * max(pushes)

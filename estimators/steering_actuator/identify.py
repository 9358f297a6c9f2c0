"""The servo model from fault-free drives: least squares of what it does not foresee of the motor's angle.

Prediction errors of an output-error model with an autoregression for its noise (Ljung, System Identification, 2nd ed.,
4.2, 7.2): the output error is minimised over the model (least squares over logarithms from the best of a grid, then a
simplex, since delay, gain and zero lie in a narrow valley); the autoregression and the spread are then fitted to what
is left (`watch.fitted`). The limits are told by the drives that reach them; one that none reaches is set beyond.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares, minimize

from estimators.steering_actuator.servo_model import LONGEST_DELAY, ServoModel, simulated

GAINS, RATIOS, ZEROS = (8.0, 20.0, 40.0, 80.0, 160.0), (3.0, 8.0), (1e-3, 0.9)  # p [1/s], q / p, f to begin with
HARDEST = (0.5, 1.0)  # of the largest acceleration that is seen
STARTS, STEPS, POLISH = 3, 30, 300  # Gauss-Newton steps of a start, simulations of the simplex
NEVER_BINDS, FREE = 10.0, 1e-3  # a limit so many times higher that makes the errors worse by less than a share of FREE
_LOWEST = np.log(np.array([0.1, 0.5, 1e-4, 1e-5, 0.01, 0.1]))
_HIGHEST = np.log(np.array([1e3, 900.0, 3.0, LONGEST_DELAY, 1e4, 1e6]))  # q: so that SUBSTEP resolves it

Array = NDArray[np.float64]


def identified(demands: Sequence[Array], angles: Sequence[Array]) -> ServoModel:
    """demands, angles: of drives, each (n,) [rad of motor], a row each cell, NaN where missing. ValueError for drives
    in which the motor does not move."""
    speed, push = _largest(angles)

    def cost(logs: Array) -> float:
        return float(np.sum(_errors(logs, demands, angles) ** 2))

    first = [
        np.clip(np.log([p, min(p * r, 800.0), f, 2e-3, speed, share * push]), _LOWEST + 1e-6, _HIGHEST - 1e-6)
        for p in GAINS for r in RATIOS for f in ZEROS for share in HARDEST
    ]  # fmt: skip
    fits = [
        least_squares(
            lambda z: _errors(z, demands, angles), start, bounds=(_LOWEST, _HIGHEST), diff_step=1e-3, x_scale=0.3,
            max_nfev=STEPS,
        )
        for start in sorted(first, key=cost)[:STARTS]
    ]  # fmt: skip
    best = min(fits, key=lambda fit: fit.cost).x
    best = minimize(
        cost, best, method="Nelder-Mead", bounds=list(zip(_LOWEST, _HIGHEST, strict=True)),
        options={"maxfev": POLISH, "initial_simplex": _simplex(best)},
    ).x  # fmt: skip
    for limit in (4, 5):
        freed = best.copy()
        freed[limit] = min(best[limit] + np.log(NEVER_BINDS), _HIGHEST[limit])
        best = freed if cost(freed) < (1.0 + FREE) * cost(best) else best
    return _model(best)


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

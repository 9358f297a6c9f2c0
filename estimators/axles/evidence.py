"""What one block alone says of a change, with all else as uncertain as it is.

At theta_0 with covariance P a block has the score s and the information J (`likelihood`). Along a direction u of the
stiffnesses, nothing assumed of it, the other states n with their covariance P_n:

    J_u = J_uu - J_un (J_nn + P_n^-1)^-1 J_nu        s_u = s_u - J_un (J_nn + P_n^-1)^-1 s_n

What was told of the car (`parameters`) is among n: a difference that still moves since it is being learnt is no loss.
So theta_u = theta_0u + s_u / J_u is what the block measures, with variance 1 / J_u: the efficient score (Cox &
Hinkley, Theoretical Statistics, 1974, ch. 9.3). Directions: the difference d = ln k_f - ln k_r, and the mean of both.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.axles.likelihood import STATES

_TURN = np.eye(STATES)
_TURN[:2, :2] = [[0.5, 1.0], [-0.5, 1.0]]  # columns: a unit of d, of the mean
_BACK = np.linalg.inv(_TURN)
_OTHERS = (np.arange(1, STATES), np.array([0, *range(2, STATES)]))
LEAST = 1e-6  # information


class Evidence(NamedTuple):
    """value, variance: of d and of the mean ln k, as one block measures them; variance infinite where it says
    nothing."""

    difference: tuple[float, float]
    mean: tuple[float, float]


def evidence(theta: NDArray, P: NDArray, score: NDArray, J: NDArray) -> Evidence:
    """theta (STATES,), P (STATES, STATES): before the block; score, J: of the block there."""
    turned, slope, information = _BACK @ theta, _TURN.T @ score, _TURN.T @ J @ _TURN
    covariance = _BACK @ P @ _BACK.T
    found = []
    for u, others in enumerate(_OTHERS):
        inner = information[np.ix_(others, others)] + np.linalg.inv(covariance[np.ix_(others, others)])
        part = np.linalg.solve(inner, information[others, u])
        own = float(information[u, u] - part @ information[others, u])
        along = float(slope[u] - part @ slope[others])
        found.append((float(turned[u]) + along / own, 1.0 / own) if own > LEAST else (float(turned[u]), np.inf))
    return Evidence(found[0], found[1])


def nothing(said: Evidence) -> Evidence:
    """The same values, of which nothing is believed."""
    return Evidence(*((value, np.inf) for value, _ in said))

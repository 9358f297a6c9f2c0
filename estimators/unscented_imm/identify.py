"""The published identification: a nonlinear quarter car whose two accelerations follow those of a car on a known road.

Brancati & Tufano, Machines 2022, 10, 1221, 5.2. Decision variables c, c2, k, k3 (Table 2); objectives the root mean
square errors of a_s and a_us (eq. 20, 21) in every case, 18 for nine. The paper evolves the Pareto set with a genetic
algorithm and takes its member nearest to the origin. That member is the minimum of the sum of the squared objectives
(whatever is nearest to the origin of all that can be reached is dominated by nothing), so it is searched for directly,
by differential evolution (Storn & Price, J. Global Optimization 11, 1997). Masses and tyre stiffness are known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import differential_evolution

from estimators.compiled import compiled
from estimators.quarter_car.quarter_car import V_S, V_US, Z_S, Z_US, QuarterCar, accelerations, rk4_step

SEARCHED = ("damping", "quadratic_damping", "spring_rate", "spring_progression")
BOUNDS = ((500.0, 2e4), (0.0, 1e4), (1e4, 2.5e5), (0.0, 5e6))  # N s/m, N s^2/m^2, N/m, N/m^3: hold Table 3 and springs
SETTLE = 1.0  # s that are not judged: the quarter car begins at rest
_SIZE, _GENERATIONS, _ENOUGH = 10, 80, 1e-3  # members for each variable; convergence of the members' costs


@dataclass(frozen=True, eq=False)
class KnownCase:
    """road: heights every half step [m], (2 n - 1,); tyre_stiffness [N/m]; measured: [a_s, a_us] every step [m/s^2],
    (n, 2); step [s]."""

    road: NDArray[np.float64]
    tyre_stiffness: float
    measured: NDArray[np.float64]
    step: float


@dataclass(frozen=True, eq=False)
class Fitted:
    """errors: root mean square of each case's [a_s, a_us] [m/s^2], (cases, 2)."""

    quarter: QuarterCar
    errors: NDArray[np.float64]


@compiled
def _squares(q, road, tyre_stiffness, measured, dt, skip):
    """Mean squared errors of a_s and a_us from sample `skip` on, begun at rest."""
    state = np.array([road[0], road[0], 0.0, 0.0])
    s = us = 0.0
    n = len(measured)
    for k in range(n):
        if k >= skip:
            a_s, a_us = accelerations(q, state[Z_S], state[Z_US], state[V_S], state[V_US], tyre_stiffness, road[2 * k])
            s += (a_s - measured[k, 0]) ** 2
            us += (a_us - measured[k, 1]) ** 2
        if k < n - 1:
            state = rk4_step(q, state, tyre_stiffness, road[2 * k], road[2 * k + 1], road[2 * k + 2], dt)
    return s / (n - skip), us / (n - skip)


def errors(quarter: QuarterCar, cases: Sequence[KnownCase]) -> NDArray[np.float64]:
    """See `Fitted`."""
    squares = [_squares(quarter, c.road, c.tyre_stiffness, c.measured, c.step, round(SETTLE / c.step)) for c in cases]
    return np.sqrt(np.array(squares))


def identify(sprung_mass: float, unsprung_mass: float, cases: Sequence[KnownCase], seed: int) -> Fitted:
    """The quarter car of these masses [kg] nearest to all cases. ValueError without cases or with short ones."""
    if not cases or min(len(case.measured) * case.step for case in cases) <= 2.0 * SETTLE:
        raise ValueError(f"identification needs cases of more than {2.0 * SETTLE:g} s each")

    def at(place: Any) -> QuarterCar:
        damping, quadratic, rate, progression = (float(value) for value in place)
        return QuarterCar(sprung_mass, unsprung_mass, rate, progression, damping, quadratic)

    def cost(place: Any) -> float:
        total = float(np.sum(errors(at(place), cases) ** 2))
        return total if np.isfinite(total) else 1e30

    found = differential_evolution(
        cost, BOUNDS, popsize=_SIZE, maxiter=_GENERATIONS, tol=_ENOUGH, rng=np.random.default_rng(seed), polish=True
    )
    return Fitted(at(found.x), errors(at(found.x), cases))

"""What a set of modes assumes: a quarter car, a road and noises each; the published numbers and their correct form.

Brancati & Tufano, Machines 2022, 10, 1221. State [z_s, z_us, v_s, v_us, k_t] (m, m/s, N/m), with the road's height z_r
[m] as a sixth where the road is unknown. Measured [a_s, a_us] [m/s^2]. Modes differ in the suspension that was
identified on their road class and in the road:

    known        z_r is given: an oracle, or a made-up road of the mode's class (as published)
    state        z_r is a state that a first-order filter shapes from white noise of the mode's class

Sigma points: van der Merwe's with alpha 1, beta 0, kappa 0 (the spherical cubature rule), all weights at least 0, so
that a covariance cannot lose its definiteness to them; the paper names no weights.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.quarter_car.quarter_car import QuarterCar
from estimators.quarter_car.road_shape import shaping
from estimators.unscented_imm.markov import PUBLISHED_STEP, published, scaled

NAMES = ("z_s", "z_us", "v_s", "v_us", "k_t", "z_r")
STIFFNESS = 4  # place of k_t in the state
STEP = 1e-3  # s
MEASURED_STD = 0.5  # m/s^2: the paper's data sheet, eq. 22
START_STD = (5e-3, 5e-3, 0.1, 0.1, 3e4, 2e-2)  # sqrt(P0). Declared: the paper gives no numbers
# sqrt(q dt^3) of eq. 18 a second^(1/2): std that a state gains in one second. Declared, as the paper gives no numbers:
# what a quarter car leaves out (stops, asymmetry, the other corners) is of the order of the sensors' noise
WANDER = (1e-4, 1e-4, 0.05, 0.1, 1e3, 0.0)


@dataclass(frozen=True, eq=False)
class Settings:
    """Of a bank. quarters: per wheel and mode, shape (wheels, modes, 6), fields of QuarterCar. step [s].

    phi, wander: of each mode, how the road keeps its height [-] (1 where it is given), and the variances that a step
    adds to the states, (modes,) and (modes, n). start, start_variance: state and P0's diagonal, (n,).
    measured_variance: (2,). transition: (modes, modes), row to column, of one step.
    """

    quarters: NDArray[np.float64]
    step: float
    phi: NDArray[np.float64]
    wander: NDArray[np.float64]
    start: NDArray[np.float64]
    start_variance: NDArray[np.float64]
    measured_variance: NDArray[np.float64]
    transition: NDArray[np.float64]

    @property
    def size(self) -> int:
        """States: 5, or 6 with the road's height."""
        return len(self.start)


def transition_of(modes: int, step: float) -> NDArray[np.float64]:
    """The published matrix for a step [s]; a single filter has one mode. ValueError for other numbers of modes."""
    if modes == 1:
        return np.ones((1, 1))
    if modes != len(published()):
        raise ValueError(f"{modes} modes, valid: 1 or {len(published())}")
    return scaled(published(), PUBLISHED_STEP, step)


def known_road(quarters: list[list[QuarterCar]], stiffness: float, step: float = STEP) -> Settings:
    """Modes that are given their road. quarters: of each wheel, one a mode. stiffness: k_t expected at first [N/m]."""
    modes = len(quarters[0])
    return Settings(
        quarters=np.array(quarters, dtype=float),
        step=step,
        phi=np.ones(modes),
        wander=np.tile(np.square(WANDER[:5]) * step, (modes, 1)),
        start=np.array([0.0, 0.0, 0.0, 0.0, stiffness]),
        start_variance=np.square(START_STD[:5]),
        measured_variance=np.full(2, MEASURED_STD**2),
        transition=transition_of(modes, step),
    )


def road_as_state(
    quarters: list[list[QuarterCar]], stiffness: float, spectra: list[float], speed: float, step: float = STEP
) -> Settings:
    """Modes that know their road's class only. spectra: G at 1 rad/m of each mode [m^3]; speed [m/s]."""
    modes = len(quarters[0])
    shapes = [shaping(spectrum, speed, step) for spectrum in spectra]
    wander = np.tile(np.square(WANDER) * step, (modes, 1))
    wander[:, 5] = [spread for _, spread in shapes]
    return Settings(
        quarters=np.array(quarters, dtype=float),
        step=step,
        phi=np.array([phi for phi, _ in shapes]),
        wander=wander,
        start=np.array([0.0, 0.0, 0.0, 0.0, stiffness, 0.0]),
        start_variance=np.square(START_STD),
        measured_variance=np.full(2, MEASURED_STD**2),
        transition=transition_of(modes, step),
    )

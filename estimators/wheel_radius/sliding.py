"""Whether tyres slide so that wheel speeds tell nothing of radii: spinning and locking wheels, a car off its steering.

Not read: cells in which the front wheels differ from the rear ones by MAX_SLIP in the mean, or one side's slip from the
other's by MAX_UNLIKE. A slide (a wheel spins or locks, or the path leaves the steered one) is over when both sides have
been below MAX_SLIP for RECOVERY cells: a spinning wheel creeps back through slips that look like radii.

What the tyres transmitted when they slid, hypot(pull, lateral / g), is the grip of this road. For GRIP_MEMORY after it
cells that use more than SHARE_OF_GRIP of it are not read: there the slip curve is bent, and left and right unlike.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

MAX_SLIP = 0.03  # linear part of the slip curve, and tyres of one car differ by less
MAX_UNLIKE = 0.02  # of left and right, of which radii make less than 0.012
SPINNING, SPINNING_ALONE = 0.3, 0.1  # slip from which wheels spin or lock, and more of one side than of the other
MAX_SIDE_SLIP = 0.04  # [rad] by which the path may leave the steered one; up to 0.02 on roads, 0.6 in a slide on ice
RECOVERY = 10  # cells
SHARE_OF_GRIP, GRIP_MEMORY = 0.5, 300.0  # [-], [s]


class Sliding:
    """Follows one car."""

    def __init__(self) -> None:
        self._recovering = 0
        self._grip, self._until = np.inf, -np.inf

    def grips(self, time: float, omega: NDArray[np.float64], astray: float, used: float, moving: bool) -> bool:
        """Take a cell: may radii be read? omega: of the wheels, (4,) [rad/s], NaN where unknown; astray: angle of the
        path off the steered one [rad]; used: share of the load that the tyres transmit [-]; moving: whether any wheel
        turns as on a road."""
        slips = slips_of(omega)
        most, unlike, mean = 0.0, 0.0, 0.0
        if len(slips):
            most, unlike, mean = float(np.abs(slips).max()), float(np.ptp(slips)), abs(float(slips.mean()))
        slides = most > SPINNING or unlike > SPINNING_ALONE or abs(astray) > MAX_SIDE_SLIP
        if slides and moving and used > 0.0:
            self._grip, self._until = used, time + GRIP_MEMORY
        slides |= self._recovering > 0 and most > MAX_SLIP
        self._recovering = RECOVERY if slides else max(self._recovering - 1, 0)
        spare = time > self._until or not used > SHARE_OF_GRIP * self._grip
        return not mean > MAX_SLIP and not unlike > MAX_UNLIKE and self._recovering == 0 and spare


def slips_of(omega: NDArray[np.float64]) -> NDArray[np.float64]:
    """Front over rear wheel, less one [-], of the sides that are known."""
    with np.errstate(divide="ignore", invalid="ignore"):
        sides = omega[:2] / omega[2:] - 1.0
    return np.clip(sides[~np.isnan(sides)], -1e3, 1e3)

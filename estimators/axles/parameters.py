"""The numbers of both axles that a user is told, what they are when each is off by its own factor, and the car's load.

eta (NUMBERS,): ln of the factor on each of `FIELDS` of the front and then of the rear axle, and on the coupling; last
x, by which a load makes the front's m_s heavier. A load is on the whole body, whose 1 / M is in all three inverse
masses (`calibration`), so that it takes the same from each:

    1 / m_sf, 1 / m_sr, 1 / m_c   -=   (1 - e^-x) / m_sf

Unknown constants: the factors with the declared spread `told_std` (`calibration`), next to nothing for axles identified
at known pressures, 6 % for numbers that may be off by 10 %; the load with `LOAD_STD`, for nobody tells it. As states of
the likelihood they are learnt as far as a drive tells them, and what it does not tell is in the standard deviations: a
mean of both stiffnesses that rests on how the axles differ is believed only as far as their numbers are (van Trees,
Detection, Estimation, and Modulation Theory I, 1968, ch. 2.4.3). Left out: where in the car the load lies.
"""

from __future__ import annotations

import numpy as np

from estimators.axles.response import Axles
from estimators.compiled import compiled
from estimators.vertical_pressure.chain import Quarter

FIELDS = ("sprung_mass", "unsprung_mass", "belt_mass", "spring_rate", "damping", "footprint")
NUMBERS = 2 * len(FIELDS) + 2
LOAD_STD = 0.1  # Declared: 24 % more body mass is x = 0.1
_COUNT = len(FIELDS)
_LIGHTEST = 0.2  # of 1 / m_sr, at most taken from it


@compiled
def scaled(quarter, by, lighter):
    """An axle whose `FIELDS` are multiplied by `by` (6,); lighter [1/kg]: off its 1 / m_s."""
    inverse = 1.0 / (quarter.sprung_mass * by[0])
    return Quarter(
        1.0 / max(inverse - lighter, _LIGHTEST * inverse), quarter.unsprung_mass * by[1], quarter.belt_mass * by[2],
        quarter.spring_rate * by[3], quarter.damping * by[4], quarter.footprint * by[5], quarter.softer,
        quarter.hub_error,
    )  # fmt: skip


@compiled
def corrected(axles, eta, shift):
    """`axles` with eta (NUMBERS,); shift [m]: of the wheelbase."""
    by = np.exp(eta)
    lighter = (1.0 - 1.0 / by[-1]) / (axles.front.sprung_mass * by[0])
    return Axles(
        scaled(axles.front, by[:_COUNT], lighter), scaled(axles.rear, by[_COUNT : 2 * _COUNT], lighter),
        axles.coupling * by[-2] - lighter, axles.wheelbase + shift,
    )  # fmt: skip

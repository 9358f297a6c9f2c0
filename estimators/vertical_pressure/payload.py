"""How heavily each axle is laden, from the accelerations of body and hubs: no road enters.

The struts are all that bears the body, whatever the road does. With travel x_i of each corner, from the difference of
hub's and body's acceleration integrated twice,

    sum_i (k_i x_i + c_i dx_i/dt) = M (a_h + d q),    a_h: of the empty car's centre of gravity, q = (a_f - a_r) / L

M: sprung mass [kg], d: how far payload moves its centre forward [m]. Both sides pass the same filters (high-passes at
`LEAK` that make the integrals stay, band-pass `BAND`); M and M d by least squares over leaky sums. Noise
leaves some 1 % of M after 10 s (scatter of 3 s windows, scaled): what is left is the damper, which above 2 Hz makes
most of the force, so that 10 % of c is about 8 % of M, and springs stiffer under load make 24 % more body mass read as
20 % (`SYSTEMATIC`). Left free c takes half the load with it. Prior: `PRIOR_STD`; it and BAND were chosen on six pairs
of drives (seeds 70001 to 70006). Believed only where the equation explains the force (`UNEXPLAINED`), as it does not in
bends, in which lateral forces lift a body, and where the body does not twist (`TWISTED`), as one with a faulty sensor
seems to. Left out: anti-dive and -lift, left and right loaded apart.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter

from estimators.car import GRAVITY, Car
from estimators.compiled import compiled
from estimators.vertical_pressure.anti_alias import RATE
from estimators.vertical_pressure.bank import SENSOR_STD

LEAK = 0.3  # Hz
BAND = (2.0, 8.0)  # Hz: below, springs that stiffen under load count for more than the damper
MEMORY = 300.0  # s of the sums
SETTLE = 3 * RATE  # samples after a start or a gap
LEAST = 3.0  # s before it is asked
PRIOR_STD = 0.2  # of ln M. Declared: empty to full, a car bears a quarter to a third of itself
SYSTEMATIC = 0.05  # of ln M. Declared: dampers, springs
UNEXPLAINED = 0.1  # of the force's variance
TWISTED = 0.1  # of the body's variance in its twist, which a rigid body does not have: a sensor is wrong
_GROUP = 32  # samples, of which the mean is taken for that
QUIET = 0.003  # (m/s^2)^2 in the band: four times the sensors' noise; class A makes five times as much
_NOISE = SENSOR_STD**2 * 2.0 * (BAND[1] - BAND[0]) / RATE  # (m/s^2)^2 of one sensor in the band
LIGHTEST, HEAVIEST = 0.75, 1.6  # of M
_SHIFT_STD = 0.1  # m, prior of d
_SECTIONS = np.ascontiguousarray(butter(2, BAND, "band", fs=RATE, output="sos"))


@compiled
def pass_filters(sos, keeps, force, damping, heave, pitch, memory, settling, sums):
    """Adds to sums (3, 3): products of [M's and d's regressor, force], over the samples after settling (1,); all (n,).

    force: sum k D, damping: sum c D, of hub less body D. memory (9, 2 sections): moves on; rows 0 to 3: two integrals
    of each signal, 4 and 5: the last differences of heave and pitch, 6 to 8: band-passes. What is twice differenced was
    twice integrated: a high-pass with the same delays.
    """
    dt = 1.0 / RATE
    y = np.empty(3)
    for t in range(len(force)):
        x = memory[0]
        x[0] = keeps * x[0] + dt * force[t]
        x[1] = keeps * x[1] + dt * x[0]
        spring = x[1]
        x = memory[1]
        last = x[1]
        x[0] = keeps * x[0] + dt * damping[t]
        x[1] = keeps * x[1] + dt * x[0]
        y[2] = spring + (x[1] - last) / dt
        for j in range(2):
            x, u = memory[2 + j], heave[t] if j == 0 else pitch[t]
            last = x[1]
            x[0] = keeps * x[0] + dt * u
            x[1] = keeps * x[1] + dt * x[0]
            rate = (x[1] - last) / dt
            y[j] = (rate - memory[4 + j, 0]) / dt
            memory[4 + j, 0] = rate
        for j in range(3):
            z = memory[6 + j]
            v = y[j]
            for s in range(sos.shape[0]):
                u = v
                v = sos[s, 0] * u + z[2 * s]
                z[2 * s] = sos[s, 1] * u - sos[s, 4] * v + z[2 * s + 1]
                z[2 * s + 1] = sos[s, 2] * u - sos[s, 5] * v
            y[j] = v
        if settling[0] > 0:
            settling[0] -= 1
            continue
        for i in range(3):
            for j in range(3):
                sums[i, j] += y[i] * y[j]


class Payload:
    """load: of the front and the rear axle over the empty car's sprung mass there; std: of ln load."""

    def __init__(self, car: Car) -> None:
        self._car = car
        self._rate = np.array([car.front_spring_rate] * 2 + [car.rear_spring_rate] * 2)
        self._damping = np.array([car.front_damping] * 2 + [car.rear_damping] * 2)
        self._keeps = math.exp(-2.0 * math.pi * LEAK / RATE)
        a, b = car.cg_to_front_axle / car.wheelbase, car.cg_to_rear_axle / car.wheelbase
        skew = 0.5 * (b - a) / car.wheelbase
        self._noise = _NOISE * np.array([[0.5 * (a**2 + b**2), skew], [skew, 1.0 / car.wheelbase**2]])
        self._sums, self._seconds = np.zeros((3, 3)), 0.0
        self._twist, self._felt = 0.0, 0.0
        self.load, self.std = (1.0, 1.0), PRIOR_STD
        self.skip()

    def skip(self) -> None:
        """Samples are missing: the filters begin anew."""
        self._memory, self._settling = np.zeros((9, 2 * len(_SECTIONS))), np.full(1, SETTLE)

    def block(self, hub: NDArray[np.float64], body: NDArray[np.float64]) -> None:
        """A block of 1 kHz samples [m/s^2], each (n, 4), wheels fl fr rl rr; not used with a gap in it."""
        if not (np.isfinite(hub).all() and np.isfinite(body).all()):
            self.skip()
            return
        travel = hub - body
        felt = body - GRAVITY
        front, rear = 0.5 * (felt[:, 0] + felt[:, 1]), 0.5 * (felt[:, 2] + felt[:, 3])
        a, b = self._car.cg_to_front_axle, self._car.cg_to_rear_axle
        heave, pitch = (b * front + a * rear) / (a + b), (front - rear) / (a + b)
        seconds = len(hub) / RATE
        heard = self._settling[0] <= 0
        before = self._sums.copy()
        pass_filters(
            _SECTIONS, self._keeps, travel @ self._rate, travel @ self._damping, heave, pitch, self._memory,
            self._settling, self._sums,
        )  # fmt: skip
        if not heard or self._sums[0, 0] - before[0, 0] < QUIET * len(hub):
            self._sums = before
            return
        keeps = math.exp(-seconds / MEMORY)
        means = felt.reshape(-1, _GROUP, 4).mean(axis=1)
        twist = means @ np.array([1.0, -1.0, -1.0, 1.0])
        self._twist = keeps * self._twist + float(np.sum(twist**2 - 4.0 * SENSOR_STD**2 / _GROUP))
        self._felt = keeps * self._felt + float(np.sum(means**2))
        self._sums = keeps * before + (self._sums - before)
        self._seconds = keeps * self._seconds + seconds
        if self._seconds > LEAST:
            self._solve()

    def _solve(self) -> None:
        """Least squares with the prior; M's own std is that of its systematic part and of the residual."""
        S, empty = self._sums, self._car.chassis_mass
        count = 2.0 * (BAND[1] - BAND[0]) * self._seconds  # independent samples
        normal = S[:2, :2] - self._noise * (self._seconds * RATE)
        unexplained = S[2, 2] - S[:2, 2] @ np.linalg.solve(S[:2, :2], S[:2, 2])
        if unexplained > UNEXPLAINED * S[2, 2] or self._twist > TWISTED * self._felt:
            self.load, self.std = (1.0, 1.0), PRIOR_STD
            return
        per_sample = unexplained / (self._seconds * RATE)
        normal[1, 1] += per_sample / (empty * _SHIFT_STD) ** 2 * (self._seconds * RATE / count)
        mass, moment = np.linalg.solve(normal, S[:2, 2])
        if not (mass > 0.5 * empty and mass < 2.0 * empty):
            self.load, self.std = (1.0, 1.0), PRIOR_STD
            return
        noise = per_sample * (self._seconds * RATE / count) * np.linalg.inv(normal)[0, 0] / mass**2
        heard = SYSTEMATIC**2 + float(noise)
        share = PRIOR_STD**2 / (PRIOR_STD**2 + heard)
        total = math.exp(share * math.log(mass / empty))
        a, b, d = self._car.cg_to_front_axle, self._car.cg_to_rear_axle, share * float(moment / mass)
        front, rear = np.clip([total * (b + d) / b, total * (a - d) / a], LIGHTEST, HEAVIEST)
        self.load = float(front), float(rear)
        self.std = math.sqrt(share * heard)

"""Left against right wheel of each axle by yaw rate (Persson et al. 2002), their five states and four more, ISO signs.

x = (yaw rate [rad/s], yaw acceleration [rad/s^2], gyro offset [rad/s], delta34, delta12, unlike34, unlike12, track
error rear, front [-]),
delta34 = r3/r4 - 1 (rear), delta12 = r1/r2 - 1 (front), wheels fl fr rl rr = 1 2 3 4. A left turn is positive:
    gyro                            = yaw + offset
    R (w4 - w3) / t_r               = yaw + (R w3 / t_r) (delta34 - pull_r unlike34)
    R (w2 - w1) / (t_f cos d)       = yaw + (R w1 / (t_f cos d)) (delta12 - pull_f unlike12)
The paper writes both wheel lines with the opposite yaw (SAE axes), without cos d and without slip: `unlike` is the 1/k
of the left wheel less the right one's, since a tyre that has lost pressure also slips less under the same pull. `track
error` e is how much larger a track is than told, less the gyro's error of scale: yaw becomes (1 + e) yaw, which in
curves looks like a delta that turns with them. Only the yaw acceleration is driven.

What moved load does in a curve is taken off first (`curve`). In a long one it moved both deltas by as much as 20 % of
pressure, one side alike, and at a hard pull by as much the other way.

At constant speed one rank short: an offset looks like both deltas. They part when the speed changes or while the car
stands (yaw = 0: the gyro reads its offset). So the speed enters the information through an anchor, the pull too, and
the covariance stays within the prior (`bounded_filter`). Without a gyro, lateral acceleration over speed stands in; its
offset [m/s^2] is the third state then. Left out: bank for the yaw rate of that stand-in.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.wheel_radius.bounded_filter import Anchor, BoundedFilter
from estimators.wheel_radius.motion import Motion
from estimators.wheel_radius.noise import NoiseLevel

DELTA_STD = 5e-3  # equal tyres differ by 0.3-0.6 %
DRIFT = 1e-4  # [1/sqrt(s)] of a delta: a step of 0.25 % is followed within a minute
UNLIKE_STD, UNLIKE_DRIFT = 2.5e-3, 2e-4  # [-], [1/sqrt(s)]: a low tyre's 1/k is a tenth smaller
TRACK_STD = 0.06  # [-] of a track and a gyro's scale
TURN_EXCITATION = 2e-3  # [1/m] of curvature from which it tells a track from a radius; below, 6 % is 2e-4 of radius
PULL_EXCITATION = 0.02  # [-] by which the pull must move to tell slip from radius
SMOOTHING = 10.0  # cells over which the pull is averaged before
OFFSET_STD = (0.005, 0.1)  # gyro [rad/s], lateral accelerometer standing in for it [m/s^2] (bank, mounting)
OFFSET_DRIFT = (5e-6, 2e-3)  # per sqrt(s)
GYRO_NOISE = (1e-3, 0.05)  # of a cell [rad/s], [m/s^2], before it is measured
LEAST_GYRO = 0.1  # of that, which a measurement may not fall below
LEAST_SHARE = 0.1  # of the noise between the axles that either of them has
YAW_STD = (1.0, 1.0)  # [rad/s], [rad/s^2]
YAW_JERK = 2.0  # [rad/s^3], std of the random yaw input
EXCITATION = 0.02  # relative change of speed that parts offset and radius
STANDSTILL_NOISE = 1e-4  # [rad/s] of a yaw rate that is zero
LONGEST_STEP = 0.25  # [s]; after a longer gap the yaw motion is unknown
SPEED_ERROR = 0.1  # [rad/s] of a cell's wheel speed before it is measured
STATES = 9
REAR, FRONT = 3, 4  # states of the deltas; those of unlike slip stand UNLIKE behind
UNLIKE = 2
TRACK = 4  # behind the deltas: relative error of the track that is told, less the gyro's of scale


class Lateral:
    """Running filter. drift: of the deltas, 0 for constants (learning)."""

    def __init__(self, car: Car, drift: float = DRIFT) -> None:
        self._car, self._drift = car, drift
        self._start(stand_in=False)

    def _start(self, stand_in: bool) -> None:
        """Set the prior for a source of yaw: the gyro, or the lateral accelerometer standing in for it."""
        self._stand_in = stand_in
        unlike = 0.0 if self._drift == 0.0 else UNLIKE_DRIFT
        self._filter = BoundedFilter(
            [0.0] * STATES,
            [*YAW_STD, OFFSET_STD[stand_in], DELTA_STD, DELTA_STD, UNLIKE_STD, UNLIKE_STD, TRACK_STD, TRACK_STD],
            [0.0, 0.0, OFFSET_DRIFT[stand_in], self._drift, self._drift, unlike, unlike, 0.0, 0.0],
        )
        self._noise = PairNoise(self._car, GYRO_NOISE[stand_in] * (0.1 if stand_in else 1.0))
        self._still = NoiseLevel(GYRO_NOISE[stand_in] ** 2)
        self._anchor = Anchor()
        self._pulls = {REAR: Anchor(SMOOTHING), FRONT: Anchor(SMOOTHING)}
        self._stepped: float | None = None
        self.seconds = {REAR: 0.0, FRONT: 0.0}

    def step(self, motion: Motion) -> None:
        """Take one cell."""
        if motion.stand_in != self._stand_in:
            self._start(motion.stand_in)
        elapsed = 0.1 if self._stepped is None else motion.time - self._stepped
        self._stepped = motion.time
        usable = not np.isnan(motion.gyro) and (motion.readable or motion.standing)
        continued = usable and elapsed < LONGEST_STEP
        self._filter.predict(elapsed, *yaw_step(elapsed if continued else np.inf))
        if not continued:
            self._noise.interrupt()
        if not usable:
            return
        gyro_row = np.zeros(STATES)
        gyro_row[0], gyro_row[2] = 1.0, motion.gyro_gain
        if motion.standing:
            self._filter.update(0.0, np.eye(STATES)[0], STANDSTILL_NOISE**2)
            explained = self._filter.spread(gyro_row)
            self._still.add(self._filter.update(motion.gyro, gyro_row, self._still.variance), explained)
            return
        self._still.interrupt()
        self._read_wheels(motion, gyro_row)

    def _read_wheels(self, motion: Motion, gyro_row: NDArray[np.float64]) -> None:
        """Update with gyro, rear and front axle, each as noisy as it was measured to be."""
        anchored = self._anchor.follow(motion.speed, EXCITATION * motion.speed)
        yaw = motion.gyro - motion.gyro_gain * float(self._filter.state[2])
        turn = yaw if abs(yaw) > TURN_EXCITATION * motion.speed else 0.0
        measured, rows, gains = [motion.gyro], [gyro_row], [gyro_row]
        for state in (REAR, FRONT):
            pull = float(motion.pull[0 if state == FRONT else 1])
            value, row = wheel_line(self._car, state, motion.omega, motion.cos_steer, pull)
            row[state + TRACK] = yaw
            gain = row.copy()
            gain[state + TRACK] = turn
            gain[state] = anchored / axle_track(self._car, state, motion.cos_steer)
            gain[state + UNLIKE] = -gain[state] * self._pulls[state].follow(pull, PULL_EXCITATION)
            measured.append(value - float(motion.curve[0 if state == FRONT else 1]) * row[state])
            rows.append(row)
            gains.append(gain)
        variances = self._noise.variances()
        self._noise.add(self._filter, measured, rows)
        least = LEAST_GYRO * GYRO_NOISE[self._stand_in] * motion.gyro_gain
        self._filter.update(motion.gyro, gyro_row, max(variances[0], least**2))
        for i, state in ((1, REAR), (2, FRONT)):
            if not np.isnan(measured[i]):
                self._filter.update(measured[i], rows[i], variances[i], gains[i])
                self.seconds[state] += 0.1

    def delta(self, state: int) -> tuple[float, float]:
        """(r_left / r_right - 1, std) of an axle, REAR or FRONT [-]."""
        return float(self._filter.state[state]), float(self._filter.std[state])

    def offset(self) -> tuple[float, float]:
        """(offset, std) of the gyro [rad/s], or of the accelerometer standing in for it [m/s^2]."""
        return float(self._filter.state[2]), float(self._filter.std[2])

    def track_errors(self) -> tuple[float, float]:
        """How much larger the rear and the front track are than told [-], as the gyro scales them."""
        return float(self._filter.state[REAR + TRACK]), float(self._filter.state[FRONT + TRACK])

    def delta_covariance(self) -> NDArray[np.float64]:
        """Of (delta12, delta34), shape (2, 2)."""
        return self._filter.covariance[np.ix_((FRONT, REAR), (FRONT, REAR))]


class PairNoise:
    """Noise of gyro, rear and front yaw rate from their three differences, in which the yaw itself cancels.

    gyro: its std [rad/s] before it is measured.
    """

    def __init__(self, car: Car, gyro: float) -> None:
        error = SPEED_ERROR * car.rolling_radius
        rear, front = 2.0 * (error / car.rear_track) ** 2, 2.0 * (error / car.front_track) ** 2
        self._rear_gyro, self._front_gyro = NoiseLevel(rear + gyro**2), NoiseLevel(front + gyro**2)
        self._rear_front = NoiseLevel(rear + front)

    def variances(self) -> tuple[float, float, float]:
        """Of gyro, rear, front [(rad/s)^2]; rear and front add up to what their difference shows."""
        with_gyro = self._rear_gyro.variance, self._front_gyro.variance
        both = self._rear_front.variance
        share = min(max(0.5 + 0.5 * (with_gyro[0] - with_gyro[1]) / both, LEAST_SHARE), 1.0 - LEAST_SHARE)
        return max(0.5 * (sum(with_gyro) - both), 0.0), share * both, (1.0 - share) * both

    def add(self, kalman: BoundedFilter, measured: list[float], rows: list[NDArray[np.float64]]) -> None:
        """The differences of one cell before it is used: gyro, rear and front [rad/s] and their rows."""
        pairs = ((1, 0, self._rear_gyro), (2, 0, self._front_gyro), (1, 2, self._rear_front))
        for a, b, level in pairs:
            if np.isnan(measured[a] - measured[b]):
                level.interrupt()
                continue
            row = rows[a] - rows[b]
            level.add(kalman.innovation(measured[a] - measured[b], row), kalman.spread(row))

    def interrupt(self) -> None:
        """The next cell does not follow on the last one."""
        for level in (self._rear_gyro, self._front_gyro, self._rear_front):
            level.interrupt()


def yaw_step(elapsed: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Transition and process noise over `elapsed` [s]; beyond `LONGEST_STEP` the yaw motion is unknown."""
    transition, noise = np.eye(STATES), np.zeros((STATES, STATES))
    if elapsed > LONGEST_STEP:
        transition[:2, :2] = 0.0
        noise[:2, :2] = np.diag(np.square(YAW_STD))
        return transition, noise
    transition[0, 1] = elapsed
    push = np.array([0.5 * elapsed**2, elapsed])
    noise[:2, :2] = YAW_JERK**2 * np.outer(push, push)
    return transition, noise


def wheel_line(
    car: Car, state: int, omega: NDArray[np.float64], cos_steer: float, pull: float = 0.0
) -> tuple[float, NDArray[np.float64]]:
    """Yaw rate that an axle's wheels (4,) [rad/s] say at nominal radius [rad/s], NaN if one is missing, and its
    measurement row (7,). pull: force over load of that axle's tyres [-]."""
    left, right = (2, 3) if state == REAR else (0, 1)
    track = axle_track(car, state, cos_steer)
    row = np.zeros(STATES)
    row[0] = 1.0
    row[state] = car.rolling_radius * float(omega[left]) / track
    row[state + UNLIKE] = -row[state] * pull
    return car.rolling_radius * float(omega[right] - omega[left]) / track, row


def axle_track(car: Car, state: int, cos_steer: float) -> float:
    """Distance of an axle's wheels across their own rolling direction [m]."""
    return car.rear_track if state == REAR else car.front_track * cos_steer

"""One residual source, or all of them, watched for a loss: `SoundCar` on calibrated residuals, `judge` on its onsets.

Residuals of a block (BLOCK seconds): ln of two torsional frequencies of each wheel, three radius contrasts, each less
what the calibration expects at that speed. What a loss d [ln pressure] of a wheel adds to them:

    antiphase, in phase     SENSITIVITY d                       d ln f / d ln p, declared from the linearised car, as
                                                                it takes the warmth of the tyres (`warming`)
    contrasts               CONTRASTS[:, wheel] sensitivity d   the car's d ln r / d p times its pressure

The three sources (vibration, radius, both) differ in nothing else. `DAY`: how far a sound car may be off its
calibration when a drive begins, at one speed and from node to node of speed; `WALK`: how far it may go within a drive.
Of the vibration they are near the maximum of the innovations' likelihood on sound drives of tuning cars (`thresholds`);
for the radius that maximum is too sure of itself in the tail, and wider values are kept.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.itpms.contrasts import RadiusBlock
from estimators.itpms.learning import CONTRAST_STD, GYRO_STD, SLIP_DIFFERENCE_STD, LearningBlock
from estimators.itpms.mode_grid import BLOCK
from estimators.itpms.mode_nodes import MODE_NODES, weights
from estimators.itpms.patterns import Judgement, judge
from estimators.itpms.sound_car import (
    BEND_DIAGONAL,
    BEND_LEFT_RIGHT,
    CONTRAST,
    FREQUENCY,
    GYRO,
    SLIP,
    SLIP_DIFFERENCE,
    STATES,
    WARMTH,
    SoundCar,
)
from estimators.itpms.speed_bins import FREQUENCIES, SIZE, Calibration
from estimators.itpms.warming import UNLIKE
from estimators.wheel_radius.noise import NoiseLevel
from estimators.wheel_radius.wheel_change import CONTRASTS

SENSITIVITY = (0.334, 0.19)
SOURCES = ("vibration", "radius", "fused")
# a block's frequency varies by WIDER times what its spectrum says, and the antiphase one's by WIDER_SLOW below SLOW
# [m/s], where the contact patch's gap is in it: there it scatters by 1.4 and one in a hundred is off by 5 to 6, always
# of a posterior that is sharp at the wrong place (5 h of tuning drives); with 1.4 three such blocks came to 13.8 nats
WIDER = (1.0, 1.2)
SLOW, WIDER_SLOW = 12.0, 2.5
# of the noise of two wheels on one side, which roll over the same road, of the antiphase frequency: correlation from
# ROAD_FROM [m/s] on, none ROAD_WITHIN below
SAME_ROAD, ROAD_FROM, ROAD_WITHIN = 0.55, 13.0, 2.0
# std of ln f (common to the four wheels, of each wheel) of the two modes: from day to day, from node to node of a day
DAY, DAY_STEP = ((0.005, 0.002), (0.036, 0.02)), ((1.5e-3, 1e-3), (0.04, 0.025))
WALK = ((2e-4, 8e-5), (6e-4, 3e-4))  # within a drive, per sqrt(s)
CONTRAST_DAY = np.array([2.5e-3, 4e-3, 3e-3])
CONTRAST_WALK = np.array([5e-6, 6e-6, 4e-6])  # per sqrt(s)
GYRO_WALK, SLIP_DAY, SLIP_WALK, BEND_DAY = 2e-5, 0.01, 1.5e-4, 0.1
LATERAL = 1.5e-4  # of a contrast per m/s^2 of lateral acceleration: load transfer
TIGHT = 0.03  # m, of left-right and diagonal per curvature: tracks as told are off, side slip turns the axles
STEERED = 1.2  # m^2, of front-rear per curvature squared: so are the wheelbase and the steering ratio
TRACTION = 2e-3  # of a contrast per normalised traction: slip that is not linear
BRAKED = 0.05  # of front-rear per normalised engine braking: brakes that help it lightly are not told from it
LEAST_NOISE = np.array([1.5e-4, 2e-4, 1.5e-4])  # of a block's contrast, whatever its neighbours scatter by
TURN = 2.0  # m/s, a change of speed that changes the calibration
STANDSTILL = 1e-4  # rad/s of the gyro's mean while the car stands


@dataclass(frozen=True)
class Block:
    """number: its end is (number + 1) BLOCK [s]; frequency: mean and std of ln f by mode and wheel, shape (2, 4, 2),
    NaN where not read; radius; speed [m/s], NaN where it is not known; warmth: of `warming`, ln pressure."""

    number: int
    frequency: NDArray[np.float64]
    radius: RadiusBlock
    speed: float
    warmth: float = 0.0

    def as_learning(self) -> LearningBlock | None:
        """What a calibration learns from it; None if nothing was read."""
        value, variance = np.full(SIZE, np.nan), np.full(SIZE, np.nan)
        frequencies = len(FREQUENCIES)
        for mode, sensitivity in enumerate(SENSITIVITY):
            rows = slice(4 * mode, 4 * mode + 4)
            value[rows] = self.frequency[mode, :, 0] - sensitivity * self.warmth
            variance[rows] = (wider(mode, self.speed) * self.frequency[mode, :, 1]) ** 2
        value[frequencies:] = self.radius.contrasts
        variance[frequencies:] = np.where(np.isfinite(value[frequencies:]), CONTRAST_STD**2, np.nan)
        if not np.isfinite(self.speed) or not np.isfinite(value).any():
            return None
        r = self.radius
        return LearningBlock(self.speed, value, variance, r.yaw_gain, r.traction, r.curvature)


def wider(mode: int, speed: float) -> float:
    """What a block's std of a mode's ln f is multiplied by at a speed [m/s]."""
    return WIDER_SLOW if mode == 0 and speed < SLOW else WIDER[mode]


def same_road(mode: int, speed: float) -> float:
    """Correlation of the noise of a mode's frequency at the two wheels of a side [-], at a speed [m/s]."""
    return SAME_ROAD * min(max((speed - ROAD_FROM) / ROAD_WITHIN + 1.0, 0.0), 1.0) if mode == 0 else 0.0


def judge_nothing() -> Judgement:
    """What is known before anything is; compiles what a calibrated drive needs."""
    car = SoundCar(np.eye(STATES))
    car.begin(0, BLOCK, np.zeros((STATES, STATES)), None)
    car.take(np.zeros(STATES), np.zeros(4), 0.0, 1.0)
    return judge(car.score, car.information)


def walk_covariance(seconds: float) -> NDArray[np.float64]:
    """Of the state's walk over a time [s], (STATES, STATES)."""
    walk = np.zeros((STATES, STATES))
    for start, mode, (common, each) in zip(FREQUENCY, MODE_NODES, WALK, strict=True):
        here = slice(start, start + 4 * mode.count)
        walk[here, here] = mode.covariance((common, each), (0.0, 0.0))
    walk[range(CONTRAST, CONTRAST + 3), range(CONTRAST, CONTRAST + 3)] = CONTRAST_WALK**2
    walk[GYRO, GYRO], walk[SLIP, SLIP] = GYRO_WALK**2, SLIP_WALK**2
    return seconds * walk


_WALK = walk_covariance(BLOCK)


class Monitor:
    """source: vibration, radius or fused."""

    def __init__(self, car: Car, calibration: Calibration, source: str) -> None:
        self._calibration, self.source = calibration, source
        self._sensitivity = car.radius_sensitivity * car.pressure
        self._drives = -1.0 if car.driven_axle == "front" else 1.0
        covariance = np.zeros((STATES, STATES))
        for m, (start, mode) in enumerate(zip(FREQUENCY, MODE_NODES, strict=True)):
            here = slice(start, start + 4 * mode.count)
            covariance[here, here] = calibration.unlearnt(m) + mode.covariance(DAY[m], DAY_STEP[m])
        covariance[range(CONTRAST, CONTRAST + 3), range(CONTRAST, CONTRAST + 3)] = CONTRAST_DAY**2
        slip_std = np.hypot(calibration.slip[1], SLIP_DAY)
        bend_std = np.hypot(calibration.bend_std, BEND_DAY)
        for state, std in (
            (GYRO, GYRO_STD), (SLIP, slip_std), (BEND_LEFT_RIGHT, bend_std[0]), (BEND_DIAGONAL, bend_std[1]),
            (SLIP_DIFFERENCE, SLIP_DIFFERENCE_STD), (WARMTH, UNLIKE),
        ):  # fmt: skip
            covariance[state, state] = std**2
        mean = np.zeros(STATES)
        mean[SLIP], mean[BEND_LEFT_RIGHT], mean[BEND_DIAGONAL] = calibration.slip[0], *calibration.bend
        self._car = SoundCar(covariance, mean)
        self._noise = [NoiseLevel(CONTRAST_STD**2) for _ in range(3)]
        self._last: int | None = None
        self._unknown = calibration.std**2
        self._speed_at: float | None = None
        self._likeliest: int | None = None
        self.read = 0
        """Blocks in which something was read."""

    def step(self, block: Block) -> Judgement | None:
        """What is known after a block; None before anything was read."""
        elapsed = 1 if self._last is None else block.number - self._last
        self._last = block.number
        self._likeliest = self._car.begin(block.number, BLOCK, elapsed * _WALK, self._likeliest)
        radius = block.radius
        if np.isfinite(radius.standstill) and self.source != "vibration":
            row = np.zeros(STATES)
            row[GYRO] = 1.0
            self._car.take(row, np.zeros(4), radius.standstill, STANDSTILL**2)
        if np.isfinite(block.speed):
            expected = self._calibration.expected(block.speed)
            self._turn(block.speed)
            count = 0
            if self.source != "radius":
                count += self._vibration(block, expected)
            if self.source != "vibration":
                count += self._radius(block, expected)
            self.read += count > 0
        if not self.read:
            return None
        judgement = judge(self._car.score, self._car.information)
        self._likeliest = judgement.onset
        return judgement

    def onset(self, judgement: Judgement) -> float:
        """When the loss of a judgement began [s]."""
        return float(self._car.onsets[judgement.onset]) * BLOCK

    def information(self, block: int, rise: float) -> NDArray[np.float64]:
        """About a loss [ln pressure] that comes within `rise` s (0 or LEAK), of the onset kept that is nearest to a
        block, shape (4, 4)."""
        places = np.flatnonzero(self._car.rise == rise)
        nearest = places[np.argmin(np.abs(self._car.onsets[places] - block))]
        return self._car.information[nearest].copy()

    def _turn(self, speed: float) -> None:
        """Another speed has other contrasts, which are as uncertain as they were learnt; a node's error is taken in
        once, half of it each time."""
        if self._speed_at is not None and abs(speed - self._speed_at) < TURN:
            return
        self._speed_at = speed
        weight = weights(speed)
        places = np.arange(CONTRAST, CONTRAST + 3)
        self._car.covariance[places, places] += self._unknown @ weight
        self._unknown *= 1.0 - 0.5 * weight

    def _vibration(self, block: Block, expected: NDArray[np.float64]) -> int:
        count = 0
        for m, (start, mode) in enumerate(zip(FREQUENCY, MODE_NODES, strict=True)):
            weight, warmed = mode.weights(block.speed), SENSITIVITY[m] * block.warmth
            by_side, scale = same_road(m, block.speed), wider(m, block.speed)
            front: dict[int, tuple[NDArray[np.float64], NDArray[np.float64], float, float]] = {}
            for wheel in range(4):
                value, std = block.frequency[m, wheel]
                if np.isnan(value):
                    continue
                row, loss, std = np.zeros(STATES), np.zeros(4), scale * std
                first = start + wheel * mode.count
                row[first : first + mode.count], row[WARMTH], loss[wheel] = weight, warmed, SENSITIVITY[m]
                rest, variance = value - expected[4 * m + wheel] - warmed, std**2
                front[wheel] = row, loss, rest, std
                if wheel - 2 in front and by_side:  # less what the front wheel has told of this road
                    ahead_row, ahead_loss, ahead_rest, ahead_std = front[wheel - 2]
                    share = by_side * std / ahead_std
                    row, loss, rest = row - share * ahead_row, loss - share * ahead_loss, rest - share * ahead_rest
                    variance *= 1.0 - by_side**2
                self._car.take(row, loss, rest, variance)
                count += 1
        return count

    def _radius(self, block: Block, expected: NDArray[np.float64]) -> int:
        radius = block.radius
        bend = radius.curvature
        modelled = (LATERAL * bend * block.speed**2) ** 2 + (TRACTION * radius.traction) ** 2
        braked = BRAKED * max(-self._drives * radius.traction, 0.0)
        bent = np.array([(TIGHT * bend) ** 2, (STEERED * bend**2) ** 2 + braked**2, (TIGHT * bend) ** 2])
        rows = np.zeros((3, STATES))
        rows[range(3), range(CONTRAST, CONTRAST + 3)] = 1.0
        rows[:, [GYRO, SLIP, BEND_LEFT_RIGHT, BEND_DIAGONAL, SLIP_DIFFERENCE]] = [
            [radius.yaw_gain, 0.0, bend, 0.0, radius.traction],
            [0.0, radius.traction, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, bend, radius.traction],
        ]
        variance = np.array([noise.variance for noise in self._noise]) + LEAST_NOISE**2 + modelled + bent
        alone = radius.contrasts
        for contrast in range(3):
            if np.isnan(alone[contrast]):
                self._noise[contrast].interrupt()
        for value, mix in zip(radius.value, radius.mixing, strict=True):
            found = self._car.take(
                mix @ rows, self._sensitivity * mix @ CONTRASTS, value - mix @ expected[len(FREQUENCIES) :],
                float(mix**2 @ variance),
            )  # fmt: skip
            if np.abs(mix).sum() == 1.0:
                self._noise[int(np.argmax(mix))].add(*found)
        return len(radius.value)

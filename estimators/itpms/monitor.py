"""One residual source, or all of them, watched for a loss: `SoundCar` on calibrated residuals, `judge` on its onsets.

Residuals of a block (BLOCK seconds): ln of two torsional frequencies of each wheel, three radius contrasts, each less
what the calibration expects at that speed. What a loss d [ln pressure] of a wheel adds to them:

    antiphase, in phase     SENSITIVITY d                       d ln f / d ln p, declared from the linearised car
    contrasts               CONTRASTS[:, wheel] sensitivity d   the car's d ln r / d p times its pressure

The three sources (vibration, radius, both) differ in nothing else. `DAY`: how far a sound car may be off its
calibration when a drive begins; `WALK`: how far it may go within a drive. Tuned on the cars of seeds 1 and 2 of
`testbed.study.itpms_fusion`, which reports another seed's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.itpms.contrasts import FRONT_REAR, LEFT_RIGHT, RadiusBlock
from estimators.itpms.mode_grid import BLOCK
from estimators.itpms.patterns import Judgement, judge
from estimators.itpms.sound_car import (
    ANTIPHASE,
    BEND_DIAGONAL,
    BEND_LEFT_RIGHT,
    CONTRAST,
    GYRO,
    IN_PHASE,
    SLIP,
    SLIP_DIFFERENCE,
    STATES,
    SoundCar,
)
from estimators.itpms.speed_bins import (
    CONTRAST_STD,
    GYRO_STD,
    SIZE,
    SLIP_DIFFERENCE_STD,
    Calibration,
    LearningBlock,
    weights,
)
from estimators.wheel_radius.noise import NoiseLevel
from estimators.wheel_radius.wheel_change import CONTRASTS

SENSITIVITY = (0.334, 0.19)
SOURCES = ("vibration", "radius", "fused")
WIDER = 1.2  # a block's frequency varies by that times what its spectrum says
# common to the four wheels, of each wheel
DAY = {"antiphase": (0.014, 0.008), "in_phase": (0.015, 0.012)}
WALK = {"antiphase": (4e-4, 1e-4), "in_phase": (5e-4, 3e-4)}  # per sqrt(s)
CONTRAST_DAY = np.array([1.2e-3, 2.5e-3, 1.2e-3])
CONTRAST_WALK = np.array([1e-5, 2e-5, 1e-5])  # per sqrt(s)
GYRO_WALK, SLIP_DAY, SLIP_WALK, BEND_DAY = 2e-5, 0.01, 2e-4, 0.05
LATERAL = 1.5e-4  # of a contrast per m/s^2 of lateral acceleration: load transfer
TIGHT = 0.03  # m, of left-right and diagonal per curvature: tracks as told are off, side slip turns the axles
STEERED = 1.2  # m^2, of front-rear per curvature squared: so are the wheelbase and the steering ratio
TRACTION = 2e-3  # of a contrast per normalised traction: slip that is not linear
LEAST_NOISE = np.array([1.5e-4, 2e-4, 1.5e-4])  # of a block's contrast that its neighbours share and no average removes
TURN = 2.0  # m/s, a change of speed that changes the calibration
STANDSTILL = 1e-4  # rad/s of the gyro's mean while the car stands


@dataclass(frozen=True)
class Block:
    """number: its end is (number + 1) BLOCK [s]; frequency: mean and std of ln f by mode and wheel, shape (2, 4, 2),
    NaN where not read; radius; speed [m/s], NaN where it is not known."""

    number: int
    frequency: NDArray[np.float64]
    radius: RadiusBlock
    speed: float

    def as_learning(self) -> LearningBlock | None:
        """What a calibration learns from it; None if nothing was read."""
        value, variance = np.full(SIZE, np.nan), np.full(SIZE, np.nan)
        value[:CONTRAST] = self.frequency[..., 0].reshape(-1)
        variance[:CONTRAST] = (WIDER * self.frequency[..., 1].reshape(-1)) ** 2
        value[CONTRAST:] = self.radius.value
        variance[CONTRAST:] = np.where(np.isfinite(self.radius.value), CONTRAST_STD**2, np.nan)
        if not np.isfinite(self.speed) or not np.isfinite(value).any():
            return None
        r = self.radius
        return LearningBlock(self.speed, value, variance, r.yaw_gain, r.traction, r.curvature)


def judge_nothing() -> Judgement:
    """What is known before anything is; compiles what a calibrated drive needs."""
    car = SoundCar(np.eye(STATES))
    car.begin(0, BLOCK, np.zeros((STATES, STATES)), None)
    car.take(np.zeros(STATES), np.zeros(4), 0.0, 1.0)
    return judge(car.score, car.information)


def _block_diagonal(common: float, each: float) -> NDArray[np.float64]:
    return common**2 * np.ones((4, 4)) + each**2 * np.eye(4)


def walk_covariance(seconds: float) -> NDArray[np.float64]:
    """Of the state's walk over a time [s], (STATES, STATES)."""
    walk = np.zeros((STATES, STATES))
    for start, mode in ((ANTIPHASE, "antiphase"), (IN_PHASE, "in_phase")):
        walk[start : start + 4, start : start + 4] = _block_diagonal(*WALK[mode])
    walk[range(CONTRAST, CONTRAST + 3), range(CONTRAST, CONTRAST + 3)] = CONTRAST_WALK**2
    walk[GYRO, GYRO], walk[SLIP, SLIP] = GYRO_WALK**2, SLIP_WALK**2
    return seconds * walk


class Monitor:
    """source: vibration, radius or fused."""

    def __init__(self, car: Car, calibration: Calibration, source: str) -> None:
        self._calibration, self.source = calibration, source
        self._sensitivity = car.radius_sensitivity * car.pressure
        covariance = np.zeros((STATES, STATES))
        for start, mode in ((ANTIPHASE, "antiphase"), (IN_PHASE, "in_phase")):
            covariance[start : start + 4, start : start + 4] = _block_diagonal(*DAY[mode])
        covariance[range(CONTRAST, CONTRAST + 3), range(CONTRAST, CONTRAST + 3)] = CONTRAST_DAY**2
        slip_std = np.hypot(calibration.slip[1], SLIP_DAY)
        bend_std = np.hypot(calibration.bend_std, BEND_DAY)
        for state, std in (
            (GYRO, GYRO_STD), (SLIP, slip_std), (BEND_LEFT_RIGHT, bend_std[0]), (BEND_DIAGONAL, bend_std[1]),
            (SLIP_DIFFERENCE, SLIP_DIFFERENCE_STD),
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
        walk = walk_covariance(BLOCK * elapsed)
        self._likeliest = self._car.begin(block.number, BLOCK, walk, self._likeliest)
        radius = block.radius
        if np.isfinite(radius.standstill) and self.source != "vibration":
            row = np.zeros(STATES)
            row[GYRO] = 1.0
            self._car.take(row, np.zeros(4), radius.standstill, STANDSTILL**2)
        if np.isfinite(block.speed):
            expected, _ = self._calibration.expected(block.speed)
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

    def _turn(self, speed: float) -> None:
        """Another speed has another calibration, which is as uncertain as it was learnt; a node's error is taken in
        once, half of it each time."""
        if self._speed_at is not None and abs(speed - self._speed_at) < TURN:
            return
        self._speed_at = speed
        weight = weights(speed)
        places = np.arange(GYRO)
        self._car.covariance[places, places] += self._unknown @ weight
        self._unknown *= 1.0 - 0.5 * weight

    def _vibration(self, block: Block, expected: NDArray[np.float64]) -> int:
        count = 0
        for mode in range(2):
            for wheel in range(4):
                value, std = block.frequency[mode, wheel]
                if np.isnan(value):
                    continue
                row, loss = np.zeros(STATES), np.zeros(4)
                row[4 * mode + wheel], loss[wheel] = 1.0, SENSITIVITY[mode]
                self._car.take(row, loss, value - expected[4 * mode + wheel], (WIDER * std) ** 2)
                count += 1
        return count

    def _radius(self, block: Block, expected: NDArray[np.float64]) -> int:
        radius, count = block.radius, 0
        bend = radius.curvature
        modelled = (LATERAL * bend * block.speed**2) ** 2 + (TRACTION * radius.traction) ** 2
        bent = (TIGHT * bend) ** 2, (STEERED * bend**2) ** 2, (TIGHT * bend) ** 2
        for contrast in range(3):
            noise = self._noise[contrast]
            if np.isnan(radius.value[contrast]):
                noise.interrupt()
                continue
            row = np.zeros(STATES)
            row[CONTRAST + contrast] = 1.0
            if contrast == FRONT_REAR:
                row[SLIP] = radius.traction
            elif contrast == LEFT_RIGHT:
                row[GYRO], row[BEND_LEFT_RIGHT] = radius.yaw_gain, radius.curvature
                row[SLIP_DIFFERENCE] = radius.traction
            else:
                row[BEND_DIAGONAL], row[SLIP_DIFFERENCE] = radius.curvature, radius.traction
            value = radius.value[contrast] - expected[8 + contrast]
            variance = noise.variance + LEAST_NOISE[contrast] ** 2 + modelled + bent[contrast]
            noise.add(*self._car.take(row, self._sensitivity * CONTRASTS[contrast], value, variance))
            count += 1
        return count

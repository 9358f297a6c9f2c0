"""How soon vibration could find a loss at one false alarm in 100 h, whatever the method: the Cramer-Rao bound.

A second of a mode that is heard has the information I about its ln f0. Whittle's bound with damping, level, slope, bend
and floors as unknown as the road is (`testbed.study.itpms_vibration.bound`), in the best of that study's cells, is

    antiphase    0.24 Hz of 87 Hz in 60 s       in phase    6 % of pressure in 60 s, at 0.19 of ln f for ln p

n tyres that lose d [ln pressure] therefore bring J = n sum over modes (g d)^2 I per second while the mode is heard
(g = d ln f / d ln p). A CUSUM that knows pattern, loss, moment and the sound car's frequencies alarms when it has
gathered ln(ARL0) nats, at J / 2 per second. Heard: antiphase from 11 m/s on (as well as there as faster: the contact
patch's gap, which weakens it, is left out, to the side of the bound), in phase between 9 and 16 m/s; so standing and
creeping in town count as waiting. Radius adds to it where fewer than four tyres are low; what limits a radius is not
noise but what else changes with traction, load and path, for which no bound is known.

That bound knows the sound car. `wandering_bound` lets it wander as the estimator declares: the same filter (`Monitor`
of the vibration alone, calibrated for ever) on frequencies as sharp as the bound above, so of the information only the
part counts by which a loss stands out of what day, speed and drive may do to a sound car and of what was heard before.
It also knows that two wheels on one side roll over the same road, which the bound of a single wheel leaves out: one low
tyre is known sooner beside its neighbour than alone, by up to 1 / (1 - SAME_ROAD^2) of information.

Four equal losses from before the drive are known by the mean ln f alone, against what a sound car's may be off: its
std s from day to day and, at a speed not learnt, of what was not learnt (as `estimators.itpms.monitor` declares both).
However long the drive, the share of such losses that passes a threshold of h nats is

    P(found) = Phi(|g d| / s - sqrt(2 h))                  since a deviation of z s has z^2 / 2 nats
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from estimators.car import Car
from estimators.itpms.contrasts import RadiusBlock
from estimators.itpms.mode_grid import BLOCK
from estimators.itpms.mode_nodes import ANTIPHASE, MODE_NODES, NODES, remaining
from estimators.itpms.monitor import DAY, DAY_STEP, SENSITIVITY, Block, Monitor
from estimators.itpms.sound_car import LEAK
from estimators.itpms.speed_bins import SIZE, Calibration
from estimators.itpms.thresholds import FALSE_ALARMS_PER_HOUR, TUNED

RECORD = 60.0  # s
# information about ln f in a second, slowest and fastest [m/s], of the default car
HEARD = (
    ((0.24 / 87.0) ** -2.0 / RECORD, 11.0, math.inf),
    ((0.06 * SENSITIVITY[1]) ** -2.0 / RECORD, 9.0, 16.0),
)
SURE = 1e8  # information about ln f at a speed at which a car learnt for long
ARL0 = 3600.0 / FALSE_ALARMS_PER_HOUR  # samples of 1 s


def information(speed: NDArray[np.float64], tyres: int, lost: NDArray[np.float64]) -> NDArray[np.float64]:
    """J of each second at speeds [m/s], shape (n,), with that share of each tyre's pressure lost, shape (n,)."""
    total = np.zeros(len(speed))
    for (told, slowest, fastest), sensitivity in zip(HEARD, SENSITIVITY, strict=True):
        heard = (speed >= slowest) & (speed <= fastest)
        total += np.where(heard, (sensitivity * np.log1p(-lost)) ** 2 * told, 0.0)
    return tyres * total


def found_by_level(share: float, learnt: float, driven: float) -> float:
    """P(found) [-] of four equal losses of that share from before the drive, of a car that learnt at one speed and is
    driven at another [m/s]."""
    known = SURE * np.outer(ANTIPHASE.weights(learnt), ANTIPHASE.weights(learnt))
    unlearnt = remaining(ANTIPHASE.spread(), np.array([known] * 4))
    mean = np.kron(np.full(4, 0.25), ANTIPHASE.weights(driven))
    wander = math.sqrt(mean @ (unlearnt + ANTIPHASE.covariance(DAY[0], DAY_STEP[0])) @ mean)
    moved = -SENSITIVITY[0] * math.log1p(-share)
    return float(norm.cdf(moved / wander - math.sqrt(2.0 * TUNED.alone["fused"])))


def detection_bound(
    speed: NDArray[np.float64], onset: float, within: float, tyres: int, share: float
) -> float | None:  # fmt: skip
    """Seconds from the moment when the share is lost to the alarm, 0 for one before; None if the drive ends first.
    speed: of each second of the drive [m/s]; the loss begins at `onset` [s] and is complete `within` [s] later."""
    since = np.arange(len(speed)) + 0.5 - onset
    lost = share * np.clip(since / max(within, 0.5), 0.0, 1.0)
    gathered, reached = 0.0, onset + within
    for second, rate in enumerate(0.5 * information(speed, tyres, lost)):
        if rate > 0.0 and gathered + rate >= math.log(ARL0):
            return max(second + (math.log(ARL0) - gathered) / float(rate) - reached, 0.0)
        gathered += float(rate)
    return None


def wandering_bound(
    speed: NDArray[np.float64], onset: float, within: float, tyres: int, share: float
) -> float | None:  # fmt: skip
    """As `detection_bound`, of the first so many tyres of fl fr rl rr, of a car that wanders as declared; to a block. A
    loss within more than a block is taken for a leak of `sound_car`'s."""
    sure = tuple(SURE * np.array([np.eye(mode.count)] * 4) for mode in MODE_NODES)
    known = Calibration(
        np.zeros((SIZE, len(NODES))), sure, np.zeros((3, len(NODES))), (0.0, 0.0), np.zeros(2), np.zeros(2)
    )
    monitor = Monitor(Car(), known, "vibration")
    unread = RadiusBlock(np.empty(0), np.empty((0, 3)), 0.0, 0.0, 0.0, math.nan, math.nan)
    low = np.where(np.arange(4) < tyres, math.log1p(-share), 0.0)
    size, start, rise = int(BLOCK), int(onset // BLOCK), LEAK if within > BLOCK else 0.0
    for number in range(len(speed) // size):
        part = speed[number * size : (number + 1) * size]
        frequency = np.full((2, 4, 2), np.nan)
        for mode, (told, slowest, fastest) in enumerate(HEARD):
            heard = int(((part >= slowest) & (part <= fastest)).sum())
            if heard:
                frequency[mode] = 0.0, (heard * told) ** -0.5
        monitor.step(Block(number, frequency, unread, float(part.mean())))
        if number >= start and 0.5 * low @ monitor.information(start, rise) @ low >= math.log(ARL0):
            return max((number + 1) * BLOCK - onset - within, 0.0)
    return None

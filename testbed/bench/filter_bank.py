"""What the compiled bank of unscented filters costs: against filterpy's own, and of real time.

Four modes of the quarter car over a class B road, 1 kHz, the road given (five states). filterpy: its IMMEstimator of
four UnscentedKalmanFilters of the same model, one wheel. Compiled: four wheels at once, everything checked and repaired
as in a drive. CPU time, so that other work on the machine counts little; fastest repetition of each.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from filterpy.kalman import IMMEstimator

from estimators.quarter_car.quarter_car import QuarterCar, ride
from estimators.quarter_car.road_shape import class_spectrum, synthesised
from estimators.unscented_imm.compiled_bank import CompiledImm
from estimators.unscented_imm.reference import ReferenceImm, quarter_step
from estimators.unscented_imm.settings import STEP, known_road

SPEED, STIFFNESS = 60.0 / 3.6, 264.7e3  # m/s, N/m
MODES = [QuarterCar(466.7, 61.14, 38e3, 2e6, damping, 0.0) for damping in (3e3, 3.2e3, 3.4e3, 3.6e3)]
FILTERPY_SHARE = 20  # the compiled bank is timed over so many times the samples


@dataclass(frozen=True)
class FilterBankCost:
    """speedup: filterpy over compiled, per wheel and sample [-]; share: of real time of one core, four wheels [-]."""

    speedup: float
    share: float


def filter_bank_cost(samples: int, repetitions: int) -> FilterBankCost:
    """samples: that filterpy is timed on."""
    steps = FILTERPY_SHARE * samples
    rng = np.random.default_rng(0)
    road = synthesised(class_spectrum("B"), SPEED, 0.5 * STEP, 2 * steps - 1, rng)
    _, felt = ride(MODES[0], road, STIFFNESS, STEP)
    measured = felt + 0.5 * rng.standard_normal(felt.shape)
    wheels = np.repeat(measured[:, None], 4, axis=1)
    given = np.tile(road[::2, None, None], (1, 4, 4))
    settings = known_road([MODES] * 4, STIFFNESS)
    CompiledImm(settings).run(wheels[:2], given[:2])
    slow, fast = [], []
    for _ in range(repetitions):
        bank = CompiledImm(settings)
        begun = time.process_time()
        bank.run(wheels, given)
        fast.append((time.process_time() - begun) / steps)
        begun = time.process_time()
        _filterpy(measured[:samples], road[::2])
        slow.append((time.process_time() - begun) / samples)
    return FilterBankCost(speedup=4.0 * min(slow) / min(fast), share=min(fast) / STEP)


def _filterpy(measured: np.ndarray, road: np.ndarray) -> None:
    settings = known_road([MODES], STIFFNESS)
    modes = ReferenceImm(settings).modes
    bank = IMMEstimator([mode.filter for mode in modes], np.full(4, 0.25), settings.transition)
    height = [0.0]  # the mixture hands no input on to its filters
    for mode, quarter in zip(modes, MODES, strict=True):
        mode.filter.fx = lambda x, dt, quarter=quarter: quarter_step(x, dt, quarter, 1.0, height[0])
        mode.filter.hx = lambda x, mode=mode: mode.felt(x, height[0])
    for sample, z_r in zip(measured, road.tolist(), strict=False):
        bank.predict()
        height[0] = z_r
        bank.update(sample)

"""Claims about the gas in the tyres: ideal gas, orifice leak, set pressure, warmth."""

from __future__ import annotations

import numpy as np
import pytest

from models.tyre_properties import load_tyre
from testbed.tyre.inflation import (
    AMOUNT,
    ATMOSPHERE,
    PRESSURE,
    TEMPERATURE,
    Leak,
    PressureSet,
    inflate,
    inflation,
    initial_gas,
)
from tests.drives import drive

COLD = 293.15  # K
P0 = 250e3  # Pa
STEP = 0.01  # s, as in the loop
STEP_TOLERANCE = 1e-3  # explicit Euler of slow exponentials at 10 ms
WARM_DRIVE = 1435.0  # W of rolling resistance per tyre at 100 km/h and p0, from a drive (a test holds it there)
PSI = 6894.757  # Pa


def run_gas(seconds, leaks=None, sets=None, power=0.0, pressure=P0, ambient=COLD, step=STEP, start=None):
    """History of the gas state of the front left tyre, shape (n + 1, 3)."""
    plan = inflation(load_tyre(), leaks or {}, sets or {}, ambient)
    gas = initial_gas(np.full(4, pressure), ambient) if start is None else start.copy()
    span, heat = np.zeros(4), np.full(4, power)
    history = [gas[0].copy()]
    for k in range(round(seconds / step)):
        inflate(plan, gas, span, heat, k * step, step)
        history.append(gas[0].copy())
    return np.array(history)


def test_leak_begins_at_its_rate_and_decays_exponentially():
    """Linear orifice at constant temperature: p(t) = p0 exp(-rate t / p0) after the start."""
    rate, start, seconds = 5e3, 2.0, 60.0
    gas = run_gas(seconds, leaks={"fl": Leak(rate, start)})
    time = np.arange(len(gas)) * STEP
    expected = P0 * np.exp(-rate * np.maximum(time - start, 0.0) / P0)
    assert gas[:, PRESSURE] == pytest.approx(expected, rel=STEP_TOLERANCE)
    first = (gas[round(start / STEP) + 100, PRESSURE] - P0) / 1.0
    assert first == pytest.approx(-rate, rel=0.02)  # over the first second the rate falls by 2 %


def test_leak_never_goes_below_the_atmosphere():
    gas = run_gas(60.0, leaks={"fl": Leak(1e6)})
    assert gas[:, PRESSURE].min() >= 0.0
    assert gas[-1, PRESSURE] < 1.0
    assert gas[-1, AMOUNT] * gas[-1, TEMPERATURE] == pytest.approx(ATMOSPHERE, rel=1e-5)


@pytest.mark.parametrize(("target", "duration"), [(0.0, 0.1), (150e3, 0.1), (300e3, 5.0)])
def test_set_reaches_its_target_in_its_time_and_stays(target, duration):
    gas = run_gas(12.0, sets={"fl": PressureSet(target, 1.0, duration)})
    before, after = round(1.0 / STEP), round((1.0 + duration) / STEP) + 1
    assert gas[: before + 1, PRESSURE] == pytest.approx(P0)
    assert gas[after:, PRESSURE] == pytest.approx(target, abs=1.0)
    middle = gas[(before + after) // 2, PRESSURE]
    assert middle == pytest.approx(0.5 * (P0 + target), abs=0.15 * abs(P0 - target))


def test_set_of_a_warm_tyre_is_its_pressure_as_it_is_warm():
    warm = initial_gas(np.full(4, P0), COLD)
    warm[:, TEMPERATURE] += 20.0
    gas = run_gas(2.0, sets={"fl": PressureSet(200e3, 0.5)}, start=warm)
    assert gas[-1, PRESSURE] == pytest.approx(200e3, rel=STEP_TOLERANCE)


def test_other_wheels_keep_their_gas():
    plan = inflation(load_tyre(), {"rr": Leak(1e4)}, {"fr": PressureSet(100e3, 0.0)}, COLD)
    gas, span = initial_gas(np.full(4, P0), COLD), np.zeros(4)
    for k in range(500):
        inflate(plan, gas, span, np.zeros(4), k * STEP, STEP)
    assert gas[:, PRESSURE] == pytest.approx([P0, 100e3, P0, P0 * np.exp(-1e4 * 5.0 / P0)], rel=STEP_TOLERANCE)


def test_tyre_warms_with_its_time_constant_to_its_steady_temperature():
    """dT = share P tau / C (1 - exp(-t / tau)): about 20 K at a steady 100 km/h (24 K before the warmth's own pressure
    lowers the rolling resistance)."""
    tyre, step = load_tyre(), 0.1
    seconds = 5.0 * tyre.thermal_time_constant
    rise = run_gas(seconds, power=WARM_DRIVE, step=step)[:, TEMPERATURE] - COLD
    steady = tyre.heat_share * WARM_DRIVE * tyre.thermal_time_constant / tyre.heat_capacity
    assert steady == pytest.approx(22.0, abs=3.0)
    time = np.arange(len(rise)) * step
    expected = steady * -np.expm1(-time / tyre.thermal_time_constant)
    assert rise == pytest.approx(expected, abs=1e-3 * steady)


def test_rolling_resistance_in_a_drive_at_100_kmh_is_the_heat_assumed_here():
    run = drive(road="flat", speed=100.0 / 3.6, duration=2.0)
    assert run["drag_loss"][-1].mean() == pytest.approx(WARM_DRIVE, rel=0.01)
    rise = run["temperature"][-1].mean() - run["temperature"][0].mean()
    tyre = load_tyre()
    assert rise == pytest.approx(tyre.heat_share * run["drag_loss"].mean() * 2.0 / tyre.heat_capacity, rel=0.01)


def test_amount_of_gas_is_conserved_and_pressure_is_ideal_while_it_warms():
    gas = run_gas(600.0, power=WARM_DRIVE, step=0.1)
    assert np.ptp(gas[:, AMOUNT]) == 0.0
    assert gas[-1, TEMPERATURE] > COLD + 5.0
    expected = (P0 + ATMOSPHERE) * gas[:, TEMPERATURE] / COLD - ATMOSPHERE
    assert gas[:, PRESSURE] == pytest.approx(expected, rel=1e-12)


def test_ten_kelvin_at_32_psi_are_1_57_psi():
    """The correction that tyre-pressure papers apply, within 2 % (it holds at 24 C)."""
    gas = initial_gas(np.full(4, 32.0 * PSI), COLD)
    gas[:, TEMPERATURE] += 10.0
    plan = inflation(load_tyre(), {}, {}, COLD + 10.0)
    inflate(plan, gas, np.zeros(4), np.zeros(4), 0.0, STEP)
    assert (gas[0, PRESSURE] - 32.0 * PSI) / PSI == pytest.approx(1.57, rel=0.02)


def test_flat_tyre_that_cools_stays_at_zero():
    gas = initial_gas(np.zeros(4), COLD)
    history = run_gas(10.0, start=gas, ambient=COLD - 30.0)
    assert history[-1, TEMPERATURE] < COLD
    assert (history[:, PRESSURE] == 0.0).all()


def test_leak_and_set_of_a_scenario_reach_the_tyre_and_its_stiffness():
    run = drive(
        road="flat",
        speed=15.0,
        duration=6.0,
        leaks={"rl": Leak(10e3, 2.0)},
        pressure_sets={"fr": PressureSet(120e3, 3.0)},
    )
    pressure = run["pressure"]
    assert pressure[1999] == pytest.approx(np.full(4, P0), rel=1e-3)
    assert pressure[-1, 2] == pytest.approx(P0 * np.exp(-10e3 * 4.0 / P0), rel=2e-3)
    assert pressure[-1, 1] == pytest.approx(120e3, rel=2e-3)
    assert run["stiffness"][-1, 1] < 0.75 * run["stiffness"][1999, 1]
    assert run["deflection"][-1, 1] > 1.3 * run["deflection"][1999, 1]

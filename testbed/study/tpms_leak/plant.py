"""A tyre on ordinary days, without a car: gas, warmth, load, and the sensor inside it. Compiled.

    gas       P = n T (1 + load) absolute, n constant but for a leak: dn/dt = -rate0 (P - Patm) / (P0 - Patm) / T
    warmth    dT/dt = (T_air + 20 K v / 100 km/h - T) / 1000 s: the testbed's tyre (models/tyres), heat as drag power
    driving   stretches of 0 to 130 km/h of 5 min in the mean, a stop of 10 min in the mean after three of ten; air
              temperature between -10 and 35 C, moving by 3 K in an hour
    load      0.1 % of volume rms anew after every stop (about 75 kg on a wheel), and 0.05 % rms within 3 s from curves,
              braking and bumps while driving
    sensor    pressure: constant error, noise, step; temperature: of the gas, 30 s late, in steps of 1 K
Declared: the figures of driving and load, and the lag.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled
from testbed.tyre.inflation import ATMOSPHERE

Array = NDArray[np.float64]

TIME_CONSTANT, HEATING, LAG = 1000.0, 20.0 / (100.0 / 3.6), 30.0  # s, K s/m, s
STEP = 1.0  # s, the longest of the plant
FASTEST, STRETCH, STOP, STOPS = 130.0 / 3.6, 300.0, 600.0, 0.3  # m/s, s, s, share
SEATED, ROLLING, ROLLING_TIME = 1e-3, 5e-4, 3.0  # -, -, s
NOMINAL = 250e3  # Pa, gauge


@dataclass(frozen=True)
class Sensor:
    """Interval [s], noise and step of the pressure [Pa]."""

    interval: float
    noise: float
    step: float


PSI = 6894.757  # Pa
SEED_SENSOR = Sensor(0.05, 0.5 * PSI, 0.0)
TESTBED_SENSOR = Sensor(1.0, 500.0, 1373.0)
SLOW_SENSORS = {"30_s": Sensor(30.0, 500.0, 2500.0), "60_s": Sensor(60.0, 500.0, 2500.0)}


@compiled
def days(state, rng, duration, interval, noise, step, leak_rate, leak_start):
    """One tyre for `duration` [s] -> times [s], pressure [Pa, gauge] and temperature [K] as its sensor sends them, true
    gauge pressure [Pa], true leak rate [Pa/s]; each of shape (n,).

    state: shape (9,), kept from call to call: time, n, T, sensor's T, speed, end of stretch, lasting load, load, air T;
    all 0 at first. rng: of all that is drawn. leak_rate: at its start [Pa/s].
    """
    if state[1] == 0.0:
        state[8] = rng.uniform(263.0, 308.0)
        state[1], state[2], state[3] = (NOMINAL + ATMOSPHERE) / state[8], state[8], state[8]
    n = int(np.rint(duration / interval))
    parts = int(np.ceil(interval / STEP))
    dt = interval / parts
    keeps = np.exp(-dt / ROLLING_TIME)
    out = np.empty((5, n))
    span = -1.0
    for i in range(n):
        rate = 0.0
        for _ in range(parts):
            state[0] += dt
            if state[0] >= state[5]:
                stops = state[4] > 0.0 and rng.random() < STOPS
                if state[4] == 0.0:
                    state[6] = SEATED * rng.standard_normal()
                state[4] = 0.0 if stops else rng.uniform(20.0 / 3.6, FASTEST)
                state[5] = state[0] + rng.exponential(STOP if stops else STRETCH)
            state[8] += 3.0 * np.sqrt(dt / 3600.0) * rng.standard_normal()
            state[8] = min(max(state[8], 263.0), 308.0)
            state[2] += dt * (state[8] + HEATING * state[4] - state[2]) / TIME_CONSTANT
            state[3] += (state[2] - state[3]) * (1.0 - np.exp(-dt / LAG))
            bumps = ROLLING if state[4] > 0.0 else 0.0
            state[7] = keeps * state[7] + np.sqrt(1.0 - keeps * keeps) * bumps * rng.standard_normal()
            gauge = state[1] * state[2] * (1.0 + state[6] + state[7]) - ATMOSPHERE
            if state[0] >= leak_start and leak_rate > 0.0:
                span = gauge if span < 0.0 else span
                rate = leak_rate * max(gauge, 0.0) / span
                state[1] -= rate * dt / state[2]
        sent = gauge + noise * rng.standard_normal()
        if step > 0.0:
            sent = step * np.rint(sent / step)
        out[0, i], out[1, i], out[2, i], out[3, i], out[4, i] = state[0], sent, np.rint(state[3]), gauge, rate
    return out


def new_state() -> Array:
    """Of a tyre at its nominal pressure."""
    return np.zeros(9)

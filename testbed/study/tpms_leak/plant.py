"""A tyre on ordinary days, without a car: gas, warmth, load, and the sensor inside it. Compiled.

    gas       P = n T (1 + load) absolute, n constant but for a leak: dn/dt = -rate0 (P - Patm) / (P0 - Patm) / T
    warmth    dT/dt = (T_air + 20 K v / 100 km/h - T) / 1000 s: the testbed's tyre (models/tyres), heat as drag power
    driving   stretches of 0 to 130 km/h of 5 min in the mean, a stop of 10 min in the mean after three of ten; air
              temperature between -10 and 35 C, moving by 3 K in an hour
    load      75 kg on the wheel rms, anew at some moment of every stop, 1.4e-5 of the volume a kg (`volume_share`), and
              0.05 % rms within 3 s from curves, braking and bumps while driving
    sensor    pressure: constant error, noise, step; temperature: of the gas, 30 s late, in steps of 1 K
Declared: the figures of driving and load, and the lag. `MISMATCHES` are tyres and days that the monitor was not tuned
for.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled
from models.tyre_properties import TyreProperties
from models.vehicle import GRAVITY
from testbed.tyre.inflation import ATMOSPHERE
from testbed.tyre.vertical import deflection, load_amplitude, pressure_factor, vertical_law

Array = NDArray[np.float64]

STEP = 1.0  # s, the longest of the plant
FASTEST, STRETCH, STOP, STOPS = 130.0 / 3.6, 300.0, 600.0, 0.3  # m/s, s, s, share
ROLLING, ROLLING_TIME = 5e-4, 3.0  # -, s
NOMINAL = 250e3  # Pa, gauge
PAYLOAD = 75.0  # kg on a wheel, rms


def volume_share(tyre: TyreProperties, load: float, payload: float) -> float:
    """Of its gas' volume that a tyre at NOMINAL loses to `payload` [kg] more than `load` [N] on it: F df / (p V), the
    virtual work of an inflated membrane, V that of a torus with the tyre's width and height."""
    law = vertical_law(tyre)
    amplitude = load_amplitude(law, pressure_factor(law, NOMINAL), 0.0, 0.0, 0.0)
    more = load + GRAVITY * payload
    way = deflection(law, amplitude, more) - deflection(law, amplitude, load)
    height = tyre.r0 - tyre.rim_radius
    volume = 2.0 * np.pi * (tyre.rim_radius + 0.5 * height) * 0.25 * np.pi * tyre.width * height
    return float(0.5 * (load + more) * way / (NOMINAL * volume))


class Days(NamedTuple):
    """What a tyre and its days are: warming [s, K s/m], the temperature sensor's lag [s] and constant error [K], volume
    a kg of load [1/kg], load changes at a stop [kg rms], or always this much and off again (`alternates`)."""

    time_constant: float = 1000.0
    heating: float = 20.0 / (100.0 / 3.6)
    lag: float = 30.0
    warmth_error: float = 0.0
    share: float = 1e-3 / 75.0
    payload: float = PAYLOAD
    alternates: bool = False


DAYS = Days()
MISMATCHES = {
    "warms_20_percent_sooner": DAYS._replace(time_constant=800.0),
    "warms_20_percent_later": DAYS._replace(time_constant=1200.0),
    "warms_20_percent_more": DAYS._replace(heating=1.2 * DAYS.heating),
    "temperature_lag_20_percent_longer": DAYS._replace(lag=36.0),
    "temperature_3_k_off": DAYS._replace(warmth_error=3.0),
    "volume_20_percent_less": DAYS._replace(share=DAYS.share / 0.8),
    "load_steps_150_kg": DAYS._replace(payload=150.0, alternates=True),
}


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
def days(plan, state, rng, duration, interval, noise, step, leak_rate, leak_start):
    """One tyre for `duration` [s] -> times [s], pressure [Pa, gauge] and temperature [K] as its sensor sends them, true
    gauge pressure [Pa], true leak rate [Pa/s], speed [m/s]; each of shape (n,).

    plan: `Days`. state: shape (11,), kept from call to call: time, n, T, sensor's T, speed, end of stretch, lasting
    load, load, air T, when the lasting load changes, and to what; all 0 at first. rng: of all that is drawn. leak_rate:
    at its start [Pa/s].
    """
    if state[1] == 0.0:
        state[8] = rng.uniform(263.0, 308.0)
        state[1], state[2], state[3] = (NOMINAL + ATMOSPHERE) / state[8], state[8], state[8]
        state[9] = np.inf
    n = int(np.rint(duration / interval))
    parts = int(np.ceil(interval / STEP))
    dt = interval / parts
    keeps = np.exp(-dt / ROLLING_TIME)
    out = np.empty((6, n))
    span = -1.0
    for i in range(n):
        rate = 0.0
        for _ in range(parts):
            state[0] += dt
            if state[0] >= state[5]:
                stops = state[4] > 0.0 and rng.random() < STOPS
                state[4] = 0.0 if stops else rng.uniform(20.0 / 3.6, FASTEST)
                state[5] = state[0] + rng.exponential(STOP if stops else STRETCH)
                if stops:
                    state[9] = rng.uniform(state[0], state[5])
                    on = 0.0 if state[6] > 0.0 else 1.0
                    state[10] = plan.share * plan.payload * (on if plan.alternates else rng.standard_normal())
            if state[0] >= state[9]:
                state[6], state[9] = state[10], np.inf
            state[8] += 3.0 * np.sqrt(dt / 3600.0) * rng.standard_normal()
            state[8] = min(max(state[8], 263.0), 308.0)
            state[2] += dt * (state[8] + plan.heating * state[4] - state[2]) / plan.time_constant
            state[3] += (state[2] - state[3]) * (1.0 - np.exp(-dt / plan.lag))
            bumps = ROLLING if state[4] > 0.0 else 0.0
            state[7] = keeps * state[7] + np.sqrt(1.0 - keeps * keeps) * bumps * rng.standard_normal()
            if state[0] > leak_start and leak_rate > 0.0:
                gauge = max(state[1] * state[2] - ATMOSPHERE, 0.0)
                span = gauge if span < 0.0 else span
                left = gauge * np.exp(-leak_rate / span * min(dt, state[0] - leak_start))
                state[1] -= (gauge - left) / state[2]
                rate = leak_rate * left / span
            gauge = state[1] * state[2] * (1.0 + state[6] + state[7]) - ATMOSPHERE
        sent = gauge + noise * rng.standard_normal()
        if step > 0.0:
            sent = step * np.rint(sent / step)
        out[0, i], out[1, i], out[2, i] = state[0], sent, np.rint(state[3] + plan.warmth_error)
        out[3, i], out[4, i], out[5, i] = gauge, rate, state[4]
    return out


def new_state() -> Array:
    """Of a tyre at its nominal pressure."""
    return np.zeros(11)

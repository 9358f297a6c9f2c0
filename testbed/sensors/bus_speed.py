"""Wheel speed on the bus, computed from the edge times only, as a brake controller does at 100 Hz.

At each update the edges since the update before are counted: speed = edges x pitch / (last edge - last edge of an
earlier update). Without a new edge the last value holds, but the wheel cannot have turned on to its next edge: speed <=
longest pitch / (time since the last edge). After `timeout` without an edge the wheel stands, and the next edge only
starts the measurement again. At the start nothing is sent until two edges, or `timeout` without one, give a speed.
The result is rounded to whole steps of circumferential speed at the nominal radius. The
sign is lost with the sensor's direction.
"""

from __future__ import annotations

import math

import numpy as np

from estimators.compiled import compiled
from testbed.sensors.motion import STEPS_PER_SECOND, FloatArray
from testbed.sensors.sampling import Clock
from testbed.sensors.settings import BusSpeedSettings

LONGEST_PITCH = 1.02  # in pitches: with the even pitch the bound would cut into the speed of an uneven ring, a bias
_REFERENCE, _FIRST, _LAST, _COUNT, _HELD = range(5)


@compiled
def speeds_at(state, updates, edges, pitch, timeout, out):
    """Speed [rad/s] at each update into out, shape (n,).

    state, shape (5,), updated: last edge of an earlier update (NaN: none), first and last edge since and their number,
    speed held. updates [s], shape (n,). edges [s], shape (m,), in order, none earlier than the update before.
    """
    at = 0
    for j in range(updates.size + 1):
        while at < edges.size and (j == updates.size or edges[at] <= updates[j]):
            if state[_COUNT] == 0.0:
                state[_FIRST] = edges[at]
            state[_LAST] = edges[at]
            state[_COUNT] += 1.0
            at += 1
        if j == updates.size:
            break
        if state[_COUNT] > 0.0:
            known = not math.isnan(state[_REFERENCE])
            turns = state[_COUNT] if known else state[_COUNT] - 1.0
            span = state[_LAST] - (state[_REFERENCE] if known else state[_FIRST])
            if span > 0.0:
                state[_HELD] = turns * pitch / span
            state[_REFERENCE], state[_COUNT] = state[_LAST], 0.0
        elif not math.isnan(state[_REFERENCE]):
            silence = updates[j] - state[_REFERENCE]
            if state[_HELD] * silence > LONGEST_PITCH * pitch:
                state[_HELD] = LONGEST_PITCH * pitch / silence
            if silence > timeout:
                state[_HELD], state[_REFERENCE] = 0.0, math.nan
        elif math.isnan(state[_HELD]) and updates[j] > timeout:
            state[_HELD] = 0.0
        out[j] = state[_HELD]


class BusSpeed:
    """One wheel's speed. teeth: of its ring. nominal_radius: [m], turns the step in m/s into one in rad/s."""

    def __init__(self, settings: BusSpeedSettings, teeth: int, nominal_radius: float) -> None:
        self._pitch, self._timeout = 2.0 * math.pi / teeth, settings.timeout
        self._step = settings.quantisation / nominal_radius
        self._clock = Clock(settings.rate)
        self._state = np.array([np.nan, 0.0, 0.0, 0.0, np.nan])

    def advance(self, first: int, last: int, edges: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Updates [s] in the steps first to last, and speeds [rad/s], from the first known speed on. edges: stamps [s]
        up to the last step."""
        updates = self._clock.due(first, last) / STEPS_PER_SECOND
        speeds = np.empty(len(updates))
        speeds_at(self._state, updates, edges, self._pitch, self._timeout, speeds)
        known = np.isfinite(speeds)
        updates, speeds = updates[known], speeds[known]
        return updates, np.rint(speeds / self._step) * self._step if self._step else speeds

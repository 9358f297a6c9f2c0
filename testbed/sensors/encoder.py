"""A wheel's toothed ring: the times at which its edges pass the Hall sensor.

Edge m (any whole number) lies at phi(m) = pitch (m + e[m mod teeth]), pitch = 2 pi / teeth. The pitches 1 + d_k of a
ring have deviations d_k that are fixed, drawn once, of the set rms, and sum to zero over the ring; e is their running
sum plus a phase. Independent pitches make the running sum grow to about three times the largest single deviation, the
ratio that ISO 1328-1 allows toothed wheels.

The sensor switches as a Schmitt trigger: at phi(m) when the ring turns forward, at phi(m) - hysteresis when it turns
back. It reports an edge each time and cannot see direction. Within a step of 1 ms the angle is the cubic Hermite
polynomial through angle and speed at both ends (exact for constant acceleration and jerk); edge times are its inverse.
Stamps are the timer's next whole tick.
"""

from __future__ import annotations

import math

import numpy as np

from estimators.compiled import compiled
from testbed.sensors.motion import STEPS_PER_SECOND, FloatArray
from testbed.sensors.settings import EncoderSettings
from testbed.sensors.streams import Seeds, stream

LARGEST_TURN = 1.0  # rad in a step: 1000 rad/s, three times the wheel speed at 400 km/h
LATENCY = 4.0  # std of jitter by which edges are late on average
_ANGLE, _SPEED, _EDGE = range(3)  # state: rim angle [rad] and speed [rad/s] of the step before, last edge passed


def tooth_ring(settings: EncoderSettings, random: np.random.Generator) -> FloatArray:
    """e, the place of each edge against the even ring, in pitches, shape (teeth,)."""
    deviation = random.standard_normal(settings.teeth)
    deviation -= deviation.mean()
    deviation *= settings.pitch_error / math.sqrt(np.mean(deviation**2))
    return random.random() + np.cumsum(deviation)


@compiled
def edge_angle(m, ring):
    """phi(m): rim angle of edge m [rad]. m: whole number as a float."""
    teeth = ring.size
    return 2.0 * math.pi / teeth * (m + ring[int(m) % teeth])


@compiled
def last_edge(angle, ring):
    """The edge m, as a float, with phi(m) <= angle < phi(m + 1)."""
    m = math.floor(angle * ring.size / (2.0 * math.pi) - ring[0])
    while edge_angle(m, ring) > angle:
        m -= 1.0
    while edge_angle(m + 1.0, ring) <= angle:
        m += 1.0
    return m


@compiled
def _crossing(level, low, high, v, c2, c3):
    """s in [low, high] at which the monotone s (v + s (c2 + s c3)) is `level`: Newton, kept in its bracket."""
    rising = high * (v + high * (c2 + high * c3)) > low * (v + low * (c2 + low * c3))
    s = 0.5 * (low + high)
    if v != 0.0 and low < level / v < high:
        s = level / v
    for _ in range(60):
        miss = s * (v + s * (c2 + s * c3)) - level
        if miss == 0.0:
            break
        if (miss > 0.0) == rising:
            high = s
        else:
            low = s
        slope = v + s * (2.0 * c2 + s * 3.0 * c3)
        step = s - miss / slope if slope != 0.0 else low
        after = step if low < step < high else 0.5 * (low + high)
        if abs(after - s) <= 1e-15:
            break
        s = after
    return s


@compiled
def _turning_points(v, c2, c3, nodes):
    """Fills nodes with 0, the points in between where s (v + s (c2 + s c3)) turns, and 1; returns how many."""
    nodes[0], count = 0.0, 1
    under = c2 * c2 - 3.0 * c3 * v
    if under > 0.0:
        q = -(c2 + math.copysign(math.sqrt(under), c2))
        first = q / (3.0 * c3) if c3 != 0.0 else -1.0
        second = v / q if q != 0.0 else -1.0
        if first > second:
            first, second = second, first
        if 0.0 < first < 1.0:
            nodes[count], count = first, count + 1
        if first < second < 1.0 and second > 0.0:
            nodes[count], count = second, count + 1
    nodes[count] = 1.0
    return count + 1


@compiled
def edge_times(state, first, angle, speed, ring, hysteresis, step):
    """Times [s] of the edges in ((first - 1) step, (first + n - 1) step], in order.

    state: shape (3,), see above, updated. first: index of the first row; the row before it is in the state.
    angle [rad], speed [rad/s]: shape (n,). ring: e, shape (teeth,). hysteresis [rad]. step [s].
    """
    times, count = np.empty(64), 0
    nodes = np.empty(4)
    for i in range(angle.size):
        start, turn = state[_ANGLE], angle[i] - state[_ANGLE]
        v, w = state[_SPEED] * step, speed[i] * step
        state[_ANGLE], state[_SPEED] = angle[i], speed[i]
        up = edge_angle(state[_EDGE] + 1.0, ring) - start
        down = edge_angle(state[_EDGE], ring) - hysteresis - start
        reach = abs(turn) + 0.15 * (abs(v) + abs(w))  # |Hermite| <= |turn| + 4/27 (|v| + |w|)
        if reach < up and -reach > down:
            continue
        c2, c3 = 3.0 * turn - 2.0 * v - w, v + w - 2.0 * turn
        pieces, place = _turning_points(v, c2, c3, nodes) - 1, 0.0
        for p in range(pieces):
            low, high, before = nodes[p], nodes[p + 1], place
            place = turn if p == pieces - 1 else high * (v + high * (c2 + high * c3))
            while (place > before and up <= place) or (place < before and place < down):
                level, way = (up, 1.0) if place > before else (down, -1.0)
                if count == times.size:
                    longer = np.empty(2 * count)
                    longer[:count] = times
                    times = longer
                low = _crossing(level, low, high, v, c2, c3)
                times[count] = (first - 1 + i + low) * step
                count += 1
                state[_EDGE] += way
                up = edge_angle(state[_EDGE] + 1.0, ring) - start
                down = edge_angle(state[_EDGE], ring) - hysteresis - start
    return times[:count]


def ticks(time: FloatArray, timer: float) -> FloatArray:
    """The timer's next whole tick [s], never before the edge (but for rounding), on the log's grid of 1 ns."""
    return np.ceil(np.ceil(time / timer) * timer * 1e9 - 1e-3) / 1e9


class Encoder:
    """One wheel's ring and sensor. name: of the signal, picks ring and random streams together with seed."""

    def __init__(self, name: str, settings: EncoderSettings, seed: int | Seeds) -> None:
        self._name, self._settings = name, settings
        self.ring = tooth_ring(settings, stream(seed, name, "part"))
        self._hysteresis = settings.hysteresis * 2.0 * math.pi / settings.teeth
        self._jitter = stream(seed, name, "noise")
        self._missing, self._double = stream(seed, name, "dropout"), stream(seed, name, "burst")
        self._state: FloatArray | None = None

    def advance(self, first: int, angle: FloatArray, speed: FloatArray) -> FloatArray:
        """Times of the reported edges [s]; false ones may lie behind the chunk's end. angle, speed: shape (n,)."""
        if self._state is None:  # the drive's first row: no step leads to it
            self._state = np.array([angle[0], speed[0], last_edge(angle[0], self.ring)])
            first, angle, speed = first + 1, angle[1:], speed[1:]
        turn = np.diff(angle, prepend=self._state[_ANGLE])
        largest = max(np.abs(turn).max(initial=0.0), np.abs(speed).max(initial=0.0) / STEPS_PER_SECOND)
        if largest > LARGEST_TURN:
            raise ValueError(
                f"{self._name}: the rim turns {largest:.3g} rad in a step of 1 ms, at most {LARGEST_TURN} can be"
            )
        s = self._settings
        true = edge_times(self._state, first, angle, speed, self.ring, self._hysteresis, 1.0 / STEPS_PER_SECOND)
        seen = true
        if s.jitter:
            late = np.clip(self._jitter.standard_normal(len(true)) + LATENCY, 0.0, 2.0 * LATENCY)
            seen = np.maximum.accumulate(true + s.jitter * late)
        reported = ticks(seen, s.timer)
        false = reported[:0]
        if s.double:
            gap = max(1.0, round(s.double_gap / s.timer)) * s.timer
            false = reported[self._double.random(len(true)) < s.double] + gap
        if s.missing:
            reported = reported[self._missing.random(len(true)) >= s.missing]
        return np.concatenate([reported, false])

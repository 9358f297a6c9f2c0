"""Edges of the toothed ring come when the closed form says, none is lost and none comes twice."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from testbed.sensors.defaults import EDGES
from testbed.sensors.edge_reference import reference_edge_times
from testbed.sensors.encoder import Encoder, edge_times, last_edge
from tests.test_sensors_motion import motion

PITCH = 2.0 * math.pi / 48
TIMER = 1e-6
TICK = TIMER * 1.001 + 1e-9  # a stamp is the timer's next whole tick; then rounding to the log's 1 ns
EVEN = replace(EDGES, pitch_error=0.0)
SIGMAS = 4.5


def rotation(angle, speed, steps):
    """Angle [rad] and speed [rad/s] of a closed form at the steps."""
    time = np.arange(steps) / 1000.0
    return np.asarray(angle(time), dtype=float), np.broadcast_to(speed(time), time.shape).astype(float).copy()


def edges_of(encoder, angle, speed, cuts=()):
    """Edge times of the rotation, handed over in one piece or cut before the given rows."""
    ends = [0, *cuts, len(angle)]
    parts = [encoder.advance(a, angle[a:b], speed[a:b]) for a, b in pairwise(ends)]
    return np.concatenate(parts)


def places(encoder, start, end):
    """Rim angles of the ring's edges in (start, end] [rad], from its pitches."""
    turns = np.arange(math.floor(start / (2 * math.pi)) - 1, math.ceil(end / (2 * math.pi)) + 1)
    every = (2 * math.pi * turns[:, None] + PITCH * (np.arange(48) + encoder.ring)).ravel()
    return every[(every > start) & (every <= end)]


@pytest.mark.parametrize("kmh", [5.0, 80.0, 200.0])
def test_constant_speed_edges_come_at_place_over_speed(kmh):
    speed = kmh / 3.6 / 0.35
    encoder = Encoder("wheel/fl/edges", EDGES, 3)
    times = edges_of(encoder, *rotation(lambda t: speed * t, lambda t: speed, 5001))
    expected = places(encoder, 0.0, speed * 5.0) / speed
    assert len(times) == len(expected)
    assert (times - expected).min() > -1e-9
    assert (times - expected).max() < TICK


def test_accelerating_edges_come_at_the_root_of_the_closed_form():
    start, gain = 2.0, 12.0
    encoder = Encoder("wheel/rr/edges", EDGES, 3)
    times = edges_of(encoder, *rotation(lambda t: start * t + 0.5 * gain * t * t, lambda t: start + gain * t, 6001))
    angle = places(encoder, 0.0, start * 6.0 + 0.5 * gain * 36.0)
    expected = (np.sqrt(start**2 + 2.0 * gain * angle) - start) / gain
    assert len(times) == len(expected)
    assert (times - expected).min() > -1e-9
    assert (times - expected).max() < TICK


def test_a_wheel_that_vibrates_at_its_torsional_mode_is_timed_to_the_hermite_error():
    mean, swing, omega = 60.0, 1.0, 2.0 * math.pi * 44.0  # rad/s, rad/s at 44 Hz
    encoder = Encoder("wheel/fl/edges", replace(EDGES, timer=1e-9), 3)
    times = edges_of(
        encoder,
        *rotation(
            lambda t: mean * t - swing / omega * np.cos(omega * t), lambda t: mean + swing * np.sin(omega * t), 2001
        ),
    )
    at_edges = mean * times - swing / omega * np.cos(omega * times)
    hermite = swing * omega**3 * 1e-12 / 384.0  # |fourth derivative| step^4 / 384 [rad]
    expected = places(encoder, at_edges[0] - 0.5 * PITCH, at_edges[-1] + 1e-6)
    assert np.abs(at_edges - expected).max() < hermite + 1e-9 * mean * 2.0


def test_at_200_kmh_several_edges_fall_into_a_step_and_all_are_counted():
    speed = 200.0 / 3.6 / 0.33
    encoder = Encoder("wheel/fl/edges", EDGES, 1)
    times = edges_of(encoder, *rotation(lambda t: speed * t, lambda t: speed, 10_001))
    per_step = np.bincount((times * 1000.0).astype(int))
    assert per_step.max() == 2
    assert abs(len(times) - speed * 10.0 / PITCH) <= 1.0


def test_ring_pitches_repeat_each_turn_sum_to_zero_and_have_the_set_rms():
    speed = 2.0 * math.pi  # a turn a second
    encoder = Encoder("wheel/fl/edges", replace(EDGES, pitch_error=0.01, timer=1e-9), 9)
    times = edges_of(encoder, *rotation(lambda t: speed * t, lambda t: speed, 10_001))
    deviation = np.diff(times) * speed / PITCH - 1.0
    turns = deviation[: len(deviation) // 48 * 48].reshape(-1, 48)
    noise = 1e-9 * speed / PITCH * 2.0  # two stamps of 1 ns
    assert np.ptp(turns, axis=0).max() < 2.0 * noise
    assert abs(turns[0].sum()) < 48 * noise
    assert math.sqrt(np.mean(turns[0] ** 2)) == pytest.approx(0.01, rel=1e-5)


def test_each_wheel_and_seed_has_its_own_ring_and_the_same_one_again():
    rings = [Encoder(f"wheel/{w}/edges", EDGES, seed).ring for w in ("fl", "fr") for seed in (1, 2)]
    for i in range(4):
        for j in range(i):
            assert np.abs(rings[i] - rings[j]).max() > 1e-3
    assert np.array_equal(rings[0], Encoder("wheel/fl/edges", EDGES, 1).ring)


def _on_an_edge(encoder):
    return PITCH * (7 + float(encoder.ring[7]))


def test_a_tooth_that_rests_and_trembles_on_an_edge_does_not_chatter():
    encoder = Encoder("wheel/fl/edges", EDGES, 4)
    swing = 0.45 * EDGES.hysteresis * PITCH
    middle, omega = _on_an_edge(encoder), 2.0 * math.pi * 13.0
    trembling = rotation(
        lambda t: middle + swing * np.sin(omega * t), lambda t: swing * omega * np.cos(omega * t), 60_000
    )
    assert len(edges_of(encoder, *trembling)) <= 1
    encoder = Encoder("wheel/fl/edges", replace(EDGES, hysteresis=0.0), 4)
    still = rotation(lambda t: middle + 0.0 * t, lambda t: 0.0, 60_000)
    assert len(edges_of(encoder, *still)) == 0


def test_rocking_beyond_the_hysteresis_counts_an_edge_each_way():
    encoder = Encoder("wheel/fl/edges", EDGES, 4)
    swing, omega = 0.3 * PITCH, 2.0 * math.pi * 2.0
    middle = _on_an_edge(encoder)
    rocking = rotation(lambda t: middle - swing * np.cos(omega * t), lambda t: swing * omega * np.sin(omega * t), 5001)
    assert len(edges_of(encoder, *rocking)) == 20  # ten periods of 0.5 s


def test_turning_back_passes_the_same_edges_shifted_by_the_hysteresis():
    encoder = Encoder("wheel/fl/edges", replace(EDGES, timer=1e-9), 4)
    gain = -8.0
    there_and_back = rotation(lambda t: 8.0 * t + 0.5 * gain * t * t, lambda t: 8.0 + gain * t, 2001)
    times = edges_of(encoder, *there_and_back)
    angle = 8.0 * times + 0.5 * gain * times**2
    out, back = angle[times < 1.0], angle[times > 1.0][::-1] + EDGES.hysteresis * PITCH
    assert len(out) > 25
    assert len(back) in (len(out), len(out) - 1)  # the first edge may lie within a hysteresis of the start
    assert back == pytest.approx(out[-len(back) :], abs=1e-6)  # slow around the turn: 1 ns is far less than this


def test_a_reversal_within_one_step_counts_both_crossings():
    encoder = Encoder("wheel/fl/edges", replace(EDGES, hysteresis=0.0, timer=1e-9), 4)
    middle, fast = _on_an_edge(encoder), 40.0  # rad/s in, the same out: the step's cubic tops 0.01 rad higher
    below = middle - 0.004
    times = encoder.advance(0, np.array([below, below]), np.array([fast, -fast]))
    s = np.roots([fast * 1e-3, -fast * 1e-3, 0.004])  # below + v s (1 - s) = middle
    assert times == pytest.approx(np.sort(s.real) * 1e-3, abs=2e-9)


def test_edges_at_chunk_borders_are_neither_lost_nor_doubled():
    speed, turns = 1000.0 * PITCH / 4.0, 10
    angle, rates = rotation(lambda t: speed * t, lambda t: speed, 48 * 4 * turns + 1)
    ends = [1, *range(5, len(angle), 4), len(angle)]
    for offset in (0.0, 1e-12, -1e-12):  # an edge at every fourth row, exactly or all but
        ring = np.full(48, offset)
        state = np.array([angle[0], rates[0], last_edge(angle[0], ring)])
        cut = [edge_times(state, a, angle[a:b], rates[a:b], ring, 0.0, 1e-3) for a, b in pairwise(ends)]
        state = np.array([angle[0], rates[0], last_edge(angle[0], ring)])
        whole = edge_times(state, 1, angle[1:], rates[1:], ring, 0.0, 1e-3)
        assert np.array_equal(np.concatenate(cut), whole)
        assert len(whole) in (48 * turns - 1, 48 * turns, 48 * turns + 1)  # the first and the last may fall either way
        assert np.diff(whole) == pytest.approx(0.004, abs=1e-12)


def test_the_first_row_of_a_drive_that_starts_rolling_makes_no_edge():
    for seed in range(20):
        assert len(Encoder("wheel/fl/edges", EDGES, seed).advance(0, np.array([3.0]), np.array([150.0]))) == 0


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_compiled_edges_equal_the_plain_reference(seed):
    random = np.random.default_rng(seed)
    n = 600
    time = np.arange(n) / 1000.0
    speed = 8.0 * np.cos(5.0 * time) + 3.0 * np.sin(2.0 * math.pi * 40.0 * time + seed) + random.standard_normal(n)
    angle = -3.0 + np.cumsum(speed) / 1000.0
    encoder = Encoder("wheel/fl/edges", EDGES, seed)
    hysteresis = EDGES.hysteresis * PITCH
    state = np.array([angle[0], speed[0], last_edge(angle[0], encoder.ring)])
    compiled = edge_times(state, 1, angle[1:], speed[1:], encoder.ring, hysteresis, 1e-3)
    reference = np.array(reference_edge_times(time, angle, speed, encoder.ring, hysteresis))
    assert len(reference) > 15
    assert len(compiled) == len(reference)
    assert compiled == pytest.approx(reference, abs=1e-11)  # bisection ends at the spacing of doubles


def test_missing_and_double_edges_come_as_often_as_set():
    speed, n = 150.0, 60_001
    angle, rates = rotation(lambda t: speed * t, lambda t: speed, n)
    full = edges_of(Encoder("wheel/fl/edges", EDGES, 1), angle, rates)
    missing = edges_of(Encoder("wheel/fl/edges", replace(EDGES, missing=0.02), 1), angle, rates)
    spread = SIGMAS * math.sqrt(len(full) * 0.02 * 0.98)
    assert set(missing) < set(full)
    assert abs(len(full) - len(missing) - 0.02 * len(full)) < spread
    double = edges_of(Encoder("wheel/fl/edges", replace(EDGES, double=0.02, double_gap=2e-4), 1), angle, rates)
    false = double[len(full) :]
    assert np.array_equal(double[: len(full)], full)
    assert abs(len(false) - 0.02 * len(full)) < spread
    assert np.isin(np.rint((false - 2e-4) * 1e6), np.rint(full * 1e6)).all()


def test_the_timer_sets_the_grid_of_the_stamps():
    angle, rates = rotation(lambda t: 30.0 * t, lambda t: 30.0, 2000)
    fine = edges_of(Encoder("wheel/fl/edges", replace(EDGES, timer=1e-9), 1), angle, rates)
    coarse = edges_of(Encoder("wheel/fl/edges", replace(EDGES, timer=1e-4), 1), angle, rates)
    assert coarse * 1e4 == pytest.approx(np.rint(coarse * 1e4), abs=1e-6)
    late = coarse - fine
    assert late.min() > -2e-9
    assert late.max() < 1e-4 + 2e-9


def test_a_rim_that_jumps_is_refused():
    encoder = Encoder("wheel/fl/edges", EVEN, 1)
    with pytest.raises(ValueError, match="wheel/fl/edges: the rim turns 1e\\+09 rad in a step"):
        encoder.advance(0, np.array([0.0, 1e9]), np.zeros(2))


def test_a_standing_car_gives_no_edges_in_any_chunk():
    still = motion(1000, rim_angle=5.0)
    encoder = Encoder("wheel/fl/edges", EDGES, 1)
    assert len(encoder.advance(0, still.rim_angle[:, 0], still.rim_speed[:, 0])) == 0

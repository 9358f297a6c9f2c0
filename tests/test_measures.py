"""Claims about the figures measured on a drive's history: the weighting is ISO 2631-1's, the fits find a known
resonance."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from testbed.measures.resonance import rotation, wheel_hop
from testbed.measures.weighting import TRANSIENT, weighted_rms, wk

RATE = 1000.0  # Hz
# ISO 2631-1:1997, table 3: one-third octave bands [10 log10 of Hz], Wk times 1000
TABLE = {
    -10: 31.2, -7: 121.0, -4: 352.0, -3: 418.0, -2: 459.0, -1: 477.0, 0: 482.0, 1: 484.0, 2: 494.0, 3: 531.0, 4: 631.0,
    5: 804.0, 6: 967.0, 7: 1039.0, 8: 1054.0, 9: 1036.0, 10: 988.0, 11: 902.0, 12: 768.0, 13: 636.0, 14: 513.0,
    15: 405.0, 16: 314.0, 17: 246.0, 18: 186.0, 19: 132.0, 20: 88.7, 23: 15.2, 26: 1.95,
}  # fmt: skip
TABLE_TOLERANCE = 0.02  # the standard's own table rounds frequencies to nominal ones
RESONANCE_TOLERANCE = 4.0  # reported standard deviations


@pytest.mark.parametrize(("band", "factor"), TABLE.items())
def test_weighting_is_that_of_the_standards_table(band, factor, claim):
    error = abs(1e3 * abs(wk(10.0 ** (0.1 * band))) / factor - 1.0)
    claim("ISO 2631-1 weighting Wk against the standard's table", 100.0 * error, 100.0 * TABLE_TOLERANCE, "%")


@pytest.mark.parametrize("frequency", [1.0, 5.0, 20.0])
def test_weighted_rms_of_a_sine_is_its_own_times_the_factor(frequency):
    time = np.arange(0.0, 20.0 + TRANSIENT, 1.0 / RATE)
    sine = 9.81 + 3.0 * np.sin(2.0 * np.pi * frequency * time)
    assert weighted_rms(sine, RATE) == pytest.approx(3.0 * abs(wk(frequency)) / np.sqrt(2.0), rel=2e-3)


def test_end_of_a_record_does_not_reach_round_to_its_start():
    quiet_then_bump = np.zeros(5000)
    quiet_then_bump[-50:] = 50.0
    felt = weighted_rms(quiet_then_bump[: -round(0.5 * RATE)], RATE)
    assert felt == pytest.approx(0.0, abs=1e-9)


def _resonance(excitation, frequency, damping, derivative):
    """Response of a second-order system, impulse invariant; its derivative where a hub's acceleration is wanted."""
    w, step = 2.0 * np.pi * frequency, 1.0 / RATE
    decay, turn = np.exp(-damping * w * step), w * np.sqrt(1.0 - damping**2) * step
    response = lfilter([1.0], [1.0, -2.0 * decay * np.cos(turn), decay**2], excitation)
    return np.gradient(response, step) if derivative else response


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("damping", [0.15, 0.3])
def test_wheel_hop_is_found_within_its_reported_error(seed, damping):
    """White road velocity through a single resonance: S = f^2 / [...], the fitted form itself."""
    rng = np.random.default_rng(seed)
    sides = [_resonance(rng.standard_normal(40_000), 11.0, damping, True) for _ in range(2)]
    found = wheel_hop(*sides, RATE)
    assert abs(found.frequency - 11.0) < RESONANCE_TOLERANCE * found.std
    assert found.std < 0.6
    assert found.damping == pytest.approx(damping, abs=0.1)


def test_wheel_hop_falls_as_its_resonance_does():
    """Common noise: the same road on a softer tyre."""
    noise = np.random.default_rng(0).standard_normal(40_000)
    stiff, soft = (_resonance(noise, f, 0.3, True) for f in (11.0, 10.0))
    ratio = wheel_hop(soft, soft, RATE).frequency / wheel_hop(stiff, stiff, RATE).frequency
    assert ratio == pytest.approx(10.0 / 11.0, rel=0.02)


@pytest.mark.parametrize(("damping", "held"), [(0.08, True), (0.5, False)])
def test_rotation_finds_both_modes_and_says_when_damping_hides_one(damping, held):
    """White noise through both resonances, one after the other: the fitted form with N = u."""
    rng = np.random.default_rng(1)
    through = [_resonance(rng.standard_normal(40_000), 39.0, damping, False) for _ in range(2)]
    in_phase, antiphase = rotation(*(_resonance(x, 86.0, 0.07, False) for x in through), RATE)
    assert abs(antiphase.frequency - 86.0) < 1.0
    if held:
        assert abs(in_phase.frequency - 39.0) < 1.0
        assert in_phase.std < 0.5
    else:
        assert in_phase.damping > 0.2

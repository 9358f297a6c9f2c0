"""Claims about the wheel's two rotational modes: where the linearised car has them, and that a drive's wheel speed has
them."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.modes import rotational_modes
from tests.drives import drive, everywhere, settled

SPEED = 30.0 / 3.6  # m/s: slow enough that the rolling contact's slip damps both modes lightly
SPECTRUM_TOLERANCE = 5e-2
CLEAT = "cleat@12:height=10,length=20,side=both"
AXLES = (("front", 0, 1.347), ("rear", 2, -1.471))
WINDOW = 250  # ms of free oscillation after the cleat


def _poles(signal, order, step):
    """Natural frequencies [Hz] and amplitudes of a sum of decaying oscillations: matrix pencil (Hua & Sarkar 1990)."""
    hankel = np.lib.stride_tricks.sliding_window_view(signal, len(signal) // 2 + 1)
    right = np.linalg.svd(hankel, full_matrices=False)[2][:order].T
    z = np.linalg.eigvals(np.linalg.pinv(right[:-1]) @ right[1:]).astype(complex)
    amplitude = np.abs(np.linalg.lstsq(np.vander(z, len(signal), increasing=True).T, signal, rcond=None)[0])
    s = np.log(z) / step
    return [(abs(p) / (2 * np.pi), a) for p, a in zip(s, amplitude, strict=True) if p.imag > 0.0]


@pytest.fixture(scope="module", params=[250e3, 187.5e3], ids=["nominal", "a quarter low"])
def computed_and_driven(request):
    pressures = everywhere(request.param)
    computed = rotational_modes(settled(speed=SPEED, pressures=pressures))
    return computed, drive(road="flat", obstacles=(CLEAT,), speed=SPEED, duration=4.0, pressures=pressures)


@pytest.mark.parametrize(("axle", "wheel", "ahead"), AXLES)
@pytest.mark.parametrize("kind", ["in_phase", "antiphase"])
def test_mode_of_the_linearised_car_is_in_the_wheel_speed_of_a_drive(
    computed_and_driven, axle, wheel, ahead, kind, claim
):
    computed, car = computed_and_driven
    past = car["position"][:, 0] + ahead > 12.30  # the cleat, its enveloping and the contact are behind the wheel
    start = int(np.argmax(past))
    speed = car["rim_speed"][:, wheel]
    free = speed[start : start + WINDOW] - speed[-1]
    found = [f for f, amplitude in _poles(free, 14, 1e-3) if amplitude > 1e-3]
    expected = computed[axle][kind].frequency
    error = min(abs(f / expected - 1.0) for f in found)
    what = "both rotational modes, front and rear, linearised against driven"
    claim(what, 100.0 * error, 100.0 * SPECTRUM_TOLERANCE, "%")


@pytest.mark.parametrize("speed", [30.0, 80.0, 130.0])
@pytest.mark.parametrize("axle", ["front", "rear"])
def test_in_phase_mode_lies_where_a_vibration_estimator_listens_and_falls_with_pressure(axle, speed, claim):
    full, low = (
        rotational_modes(settled(speed=speed / 3.6, pressures=everywhere(p)))[axle]["in_phase"].frequency
        for p in (250e3, 187.5e3)
    )
    claim("in-phase rotational mode lies within 42.5 +- 7.5 Hz", abs(full - 42.5), 7.5, "Hz")
    assert -0.08 < low / full - 1.0 < -0.03


def test_slip_damps_the_in_phase_mode_more_the_faster_the_car():
    """The rolling contact is a damper Kx/V behind the residual spring: at rest a spring only, fast a damper only."""
    damping = [rotational_modes(settled(speed=v / 3.6))["front"]["in_phase"].damping for v in (10.0, 30.0, 80.0)]
    assert damping == sorted(damping)
    assert damping[0] < 0.1

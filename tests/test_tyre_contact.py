"""Claims about the tyre as a force element: enveloping, relaxation, power balance, the flat tyre, any input finite."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from models.tyre_properties import load_tyre, tyre_names
from testbed.tyre import contact, vertical
from testbed.tyre.contact import OUTPUT, STATE, tyre_element, wheel_forces
from testbed.tyre.enveloping import cam, effective_plane, envelope_reference
from tests.drives import drive, settled

SPACING = 0.05
PLANE_TOLERANCE = 2e-3  # of a slope: the cams bend between the offsets that are looked at, by 0.01 mm
ENVELOPING_TOLERANCE = 0.03  # rms of the deviation over that of the effective height, or slope
STEP = 1e-3
LEFT = np.array([0.0, 1.0, 0.0])


def _grid(profile):
    """A height field of this profile along x [m], the same for all y, and its origin."""
    heights = np.repeat(np.asarray(profile, np.float32)[None, :], 41, axis=0)
    return np.ascontiguousarray(heights), np.array([0.0, -1.0, 0.0, SPACING])


def _wheel(
    height=0.34, speed=20.0, spin=None, fz_steps=1, pressure=250e3, friction=1.0, side=1.0, sideways=0.0, tyre=None,
    rolling=0.0,
):  # fmt: skip
    """Output, wrench and rim load of one wheel on a plane after some steps; height of the belt centre [m], rolling: its
    angular velocity about the forward direction [rad/s]."""
    element = tyre_element(tyre or load_tyre())
    heights, origin = _grid(np.zeros(200))
    state, out, wrench = np.zeros(len(STATE)), np.zeros(len(OUTPUT)), np.zeros(6)
    centre, velocity = np.array([5.0, 0.0, height]), np.array([speed, sideways, 0.0])
    spin = speed / 0.36 if spin is None else spin
    turning = np.array([rolling, spin, 0.0])
    rim_load = 0.0
    for _ in range(fz_steps):
        rim_load = wheel_forces(
            element, heights, origin, state, out, wrench, centre, 0.0, velocity, turning, spin, LEFT, pressure, 1.0,
            friction, side, STEP,
        )  # fmt: skip
    return dict(zip(OUTPUT, out, strict=True)), wrench, rim_load, state


def _enveloped(profile, spacing):
    """Height and slope by the kernel and by the dense reference, and the kernel's slope across: shapes (n,)."""
    tyre, half = load_tyre(), 0.07
    heights, _ = _grid(profile)
    origin = np.array([0.0, -20.0 * spacing, 0.0, spacing])
    reference = envelope_reference(heights[0].astype(float), spacing, tyre, half)
    shape = cam(tyre)
    got = [effective_plane(heights, origin, shape, i * spacing, 0.0, 1.0, 0.0, half) for i in range(len(profile))]
    known = np.isfinite(reference[0])
    return np.array(got).T[:, known], np.array(reference)[:, known]


def _share(error, signal):
    return np.sqrt(np.mean((error - error.mean()) ** 2) / np.mean((signal - signal.mean()) ** 2))


@pytest.mark.parametrize("seed", range(3))
def test_enveloping_kernel_is_the_dense_dilation_of_a_road(seed):
    """2001 points along each cam, on a road far rougher than any class."""
    got, reference = _enveloped(np.cumsum(np.random.default_rng(seed).normal(0.0, 0.004, 300)), SPACING)
    assert _share(got[0] - reference[0], reference[0]) < ENVELOPING_TOLERANCE
    assert _share(got[1] - reference[1], reference[1]) < ENVELOPING_TOLERANCE
    assert np.abs(got[2]).max() < 1e-6


@pytest.mark.parametrize("length", [0.02, 0.03, 0.05])
def test_enveloping_kernel_is_the_dense_dilation_of_a_cleat(length):
    """10 mm high on the 10 mm grid that roads with obstacles have."""
    profile = np.where(np.abs(0.01 * np.arange(400) - 2.0) < 0.5 * length, 0.01, 0.0)
    got, reference = _enveloped(profile, 0.01)
    assert _share(got[0] - reference[0], reference[0]) < ENVELOPING_TOLERANCE
    assert _share(got[1] - reference[1], reference[1]) < ENVELOPING_TOLERANCE


def test_road_that_rises_to_the_left_leans_the_effective_plane_so():
    heights = np.ascontiguousarray(np.repeat(0.04 * SPACING * np.arange(41.0)[:, None], 200, axis=1).astype(np.float32))
    plane = effective_plane(heights, np.array([0.0, -1.0, 0.0, SPACING]), cam(load_tyre()), 5.0, 0.0, 1.0, 0.0, 0.07)
    assert plane[2] == pytest.approx(0.04, rel=1e-4)
    assert plane[1] == pytest.approx(0.0, abs=1e-6)


def test_enveloping_of_an_inclined_plane_is_that_plane():
    slope = 0.08
    heights, origin = _grid(slope * SPACING * np.arange(200))
    tyre = load_tyre()
    height, along, _ = effective_plane(heights, origin, cam(tyre), 5.0, 0.0, 1.0, 0.0, 0.07)
    assert along == pytest.approx(slope, rel=PLANE_TOLERANCE)
    # an elliptic cam touches a plane where its own slope is the plane's, a little ahead of its lowest point
    a_e, b_e, c = tyre.ellips_length * tyre.r0, tyre.ellips_height * tyre.r0, tyre.ellips_order
    ratio = (slope * a_e / b_e) ** (c / (c - 1.0))
    share = (ratio / (1.0 + ratio)) ** (1.0 / c)
    lift = slope * a_e * share + b_e * ((1.0 - share**c) ** (1.0 / c) - 1.0)
    assert height - slope * 5.0 == pytest.approx(lift, abs=1e-5)
    back = effective_plane(heights, origin, cam(tyre), 5.0, 0.0, -1.0, 0.0, 0.07)
    assert back[1] == pytest.approx(-slope, rel=PLANE_TOLERANCE)


def test_a_step_is_felt_before_the_axle_reaches_it_and_smoothed():
    profile = np.where(np.arange(200) >= 100, 0.02, 0.0)
    height, _ = envelope_reference(profile, SPACING, load_tyre(), 0.07)
    first = int(np.argmax(height > 1e-4))
    assert 95 <= first < 100
    assert np.all(np.diff(height[40:160]) >= -1e-12)


@pytest.mark.parametrize("name", tyre_names())
def test_power_of_the_contact_is_load_work_plus_losses(name):
    """F.v + M.w on the belt = -(slip loss + drag loss): what the car loses is what the table of work says. The wheel
    also rolls about the forward direction, as a body's roll makes it."""
    tyre = load_tyre(name)
    radius = 0.92 * tyre.r0
    for spin, roll in ((18.0 / radius, 0.0), (20.0 / radius, 0.5), (23.0 / radius, -1.0)):
        out, wrench, _, _ = _wheel(
            height=radius, speed=20.0, spin=spin, fz_steps=200, sideways=0.4, tyre=tyre, rolling=roll
        )
        power = wrench[0] * 20.0 + wrench[1] * 0.4 + wrench[3] * roll + wrench[4] * spin
        assert power == pytest.approx(-(out["slip_loss"] + out["drag_loss"]), rel=1e-9)
        assert out["drag_loss"] > 0.0
        assert out["slip_loss"] >= 0.0


def test_wheel_that_rolls_about_its_contact_point_does_not_slip_sideways():
    """A body that sways about a point on the road: v_y of the belt centre = -R w_x."""
    radius, roll = 0.34, 0.8
    out, _, _, _ = _wheel(height=radius, sideways=-radius * roll, rolling=roll, fz_steps=400)
    straight, _, _, _ = _wheel(height=radius, fz_steps=400)
    assert out["slip_angle"] == pytest.approx(straight["slip_angle"], abs=1e-9)
    assert out["fy"] == pytest.approx(straight["fy"], abs=1e-6)


def test_lateral_relaxation_length_is_cornering_stiffness_over_lateral_stiffness():
    """After a small step of side slip the contact's deflection grows as 1 - exp(-distance/sigma_y)."""
    tyre, speed, sideways = load_tyre(), 5.0, 0.005
    whole, _, _, settled_state = _wheel(speed=speed, sideways=sideways, fz_steps=8000)
    sigma = abs(contact.slip_stiffness(tyre.slip_array(), whole["load"], 250e3)[1]) / tyre.cy
    assert 0.2 < sigma < 2.0
    steps = round(sigma / speed / STEP)
    part = _wheel(speed=speed, sideways=sideways, fz_steps=steps)[3][contact.SHEAR_Y]
    ratio = part / settled_state[contact.SHEAR_Y]
    assert ratio == pytest.approx(1.0 - np.exp(-steps * STEP * speed / sigma), rel=1e-3)
    assert np.tan(whole["slip_angle"]) == pytest.approx(sideways / speed, rel=1e-6)


def test_contact_length_and_drag_follow_the_published_formulas():
    """a = R0 [Q_RA2 Fz/(Cz R0) + Q_RA1 sqrt(Fz/(Cz R0))]; My carries (p/p0)^QSY8 above p0/2."""
    tyre = load_tyre("book-205-60r15")
    law = vertical.vertical_law(tyre)
    for pressure, fz in ((220e3, 4000.0), (165e3, 3000.0)):
        factor = 1.0 + tyre.pfz1 * (pressure - tyre.p0) / tyre.p0
        scaled = fz / (tyre.cz0 * factor * tyre.r0)
        wanted = tyre.r0 * (tyre.q_ra2 * scaled + tyre.q_ra1 * np.sqrt(scaled))
        assert vertical.contact_half_length(law, vertical.pressure_factor(law, pressure), fz) == pytest.approx(wanted)
    sound, low = (
        _wheel(height=0.29, speed=16.7, spin=16.7 / 0.3, pressure=p, tyre=tyre, fz_steps=50)[0] for p in (220e3, 165e3)
    )
    by_load = (low["load"] / sound["load"]) ** 0.9008
    assert low["drag_moment"] / sound["drag_moment"] == pytest.approx(0.75**-0.4089 * by_load, rel=1e-6)


def test_relaxation_length_is_slip_stiffness_over_shear_stiffness():
    """After a small step of slip the force rises as 1 - exp(-distance/sigma_x)."""
    tyre = load_tyre()
    element, speed = tyre_element(tyre), 2.6
    out, _, _, _ = _wheel(speed=speed, spin=0.0, fz_steps=1)
    radius = out["rolling_radius"]
    wanted = 1.002 * speed / radius
    final = _wheel(speed=speed, spin=wanted, fz_steps=4000)[0]
    sigma = contact.slip_stiffness(element.slip, final["load"], 250e3)[0] / element.residual_x
    steps = round(sigma / speed / STEP)
    part = _wheel(speed=speed, spin=wanted, fz_steps=steps)[3][contact.SHEAR_X]
    whole = _wheel(speed=speed, spin=wanted, fz_steps=4000)[3][contact.SHEAR_X]
    assert part / whole == pytest.approx(1.0 - np.exp(-steps * STEP * speed / sigma), rel=1e-3)
    assert final["slip_ratio"] == pytest.approx(1.002 * final["rolling_radius"] / radius - 1.0, abs=1e-5)


def test_belt_softens_what_the_standing_tyre_is_in_series():
    """c_rx, sidewall and torsion in series are the tyre's Cx, c_rz and sidewall its Cz."""
    tyre = load_tyre()
    series = 1.0 / contact.residual_longitudinal_stiffness(tyre) + 1.0 / tyre.sidewall_stiffness
    series += tyre.r0**2 / tyre.torsional_stiffness
    assert 1.0 / series == pytest.approx(tyre.cx, rel=1e-12)
    soft = dataclasses.replace(tyre, cx=2.0 * tyre.cx)
    with pytest.raises(ValueError, match="stiffer than its sidewall"):
        contact.residual_longitudinal_stiffness(soft)


def test_standing_wheel_pushed_sideways_is_a_bounded_spring():
    state = _wheel(speed=0.0, spin=0.0, sideways=0.01, fz_steps=500)
    out = state[0]
    assert out["fy"] < 0.0
    far = _wheel(speed=0.0, spin=0.0, sideways=0.01, fz_steps=20000)[0]
    assert -1.3 * far["load"] < far["fy"] < 0.0


@pytest.mark.parametrize("friction", [0.1, 0.5, 1.0])
def test_horizontal_force_stays_within_friction(friction):
    for spin, sideways in ((0.0, 0.0), (90.0, 0.0), (40.0, 5.0), (55.0, -3.0)):
        out = _wheel(spin=spin, sideways=sideways, fz_steps=2000, friction=friction)[0]
        assert np.hypot(out["fx"], out["fy"]) < 1.25 * friction * out["load"]


def test_wheel_in_the_air_has_no_forces():
    out, wrench, rim_load, _ = _wheel(height=0.5, fz_steps=3)
    assert out["load"] == 0.0
    assert rim_load == 0.0
    assert not wrench.any()


def test_any_input_gives_finite_forces():
    rng = np.random.default_rng(5)
    element = tyre_element(load_tyre())
    heights = np.ascontiguousarray(rng.uniform(0.0, 0.3, (41, 200)).astype(np.float32))
    origin = np.array([0.0, -1.0, 0.0, SPACING])
    for _ in range(3000):
        state, out, wrench = np.zeros(len(STATE)), np.zeros(len(OUTPUT)), np.zeros(6)
        axis = np.array([rng.normal(0, 0.3), 1.0, rng.normal(0, 0.2)])
        axis /= np.linalg.norm(axis)
        for _ in range(3):
            wheel_forces(
                element, heights, origin, state, out, wrench, np.array([rng.uniform(2, 8), 0.0, rng.uniform(0.1, 0.7)]),
                rng.normal(0, 0.02), rng.normal(0, 20, 3), rng.normal(0, 5, 3), rng.normal(0, 100), axis,
                rng.uniform(0, 500e3), 1.0, rng.uniform(0.05, 1.5), rng.choice([-1.0, 1.0]), STEP,
            )  # fmt: skip
        assert np.isfinite(out).all()
        assert np.isfinite(wrench).all()


def test_flat_tyre_is_carried_by_its_rim_and_still_drives():
    flat = drive(road="C", speed=50 / 3.6, duration=6.0, pressures={"rl": 0.0})
    sound = settled(speed=50 / 3.6)
    end = flat.simulation
    rim = end.data.xpos[end.index.rim[2], 2] - end.state.outputs[2, contact.ROAD_HEIGHT]
    assert rim == pytest.approx(end.element.rim_contact, abs=0.01)  # the rim stands on the folded sidewall
    assert flat["pressure"][-1, 2] < 200.0  # Pa: the air that is left warms a little
    assert flat["load"][-2000:, 2].mean() > 0.5 * sound.state.outputs[2, 0]
    assert flat["load"][-2000:].sum(axis=1).mean() == pytest.approx(sound.vehicle.mass * 9.81, rel=0.01)
    assert np.abs(flat["path_error"]).max() < 0.3
    assert flat["velocity"][-1, 0] == pytest.approx(50 / 3.6, rel=0.01)


@pytest.mark.parametrize("pressure", [0.0, 30e3, 125e3])
def test_vertical_factor_is_continuous_and_falls_to_the_carcass(pressure):
    law = vertical.vertical_law(load_tyre())
    below, above = (vertical.pressure_factor(law, max(pressure + d, 0.0)) for d in (-1.0, 1.0))
    assert 0.0 <= above - below < 5e-5
    assert vertical.pressure_factor(law, 0.0) == pytest.approx(law.carcass_fraction)

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
STEP = 1e-3
LEFT = np.array([0.0, 1.0, 0.0])


def _grid(profile):
    """A height field of this profile along x [m], the same for all y, and its origin."""
    heights = np.repeat(np.asarray(profile, np.float32)[None, :], 41, axis=0)
    return np.ascontiguousarray(heights), np.array([0.0, -1.0, 0.0, SPACING])


def _wheel(
    height=0.34, speed=20.0, spin=None, fz_steps=1, pressure=250e3, friction=1.0, side=1.0, sideways=0.0, tyre=None
):
    """Output, wrench and rim load of one wheel on a plane after some steps; height of the belt centre [m]."""
    element = tyre_element(tyre or load_tyre())
    heights, origin = _grid(np.zeros(200))
    state, out, wrench = np.zeros(len(STATE)), np.zeros(len(OUTPUT)), np.zeros(6)
    centre, velocity = np.array([5.0, 0.0, height]), np.array([speed, sideways, 0.0])
    spin = speed / 0.36 if spin is None else spin
    rim_load = 0.0
    for _ in range(fz_steps):
        rim_load = wheel_forces(
            element, heights, origin, state, out, wrench, centre, 0.0, velocity, spin, LEFT, pressure, 1.0, friction,
            side, STEP,
        )  # fmt: skip
    return dict(zip(OUTPUT, out, strict=True)), wrench, rim_load, state


@pytest.mark.parametrize("seed", range(3))
def test_enveloping_kernel_is_the_plain_dilation(seed):
    """The reference interpolates the same grid linearly, so the two agree to the float32 of the height field."""
    tyre, half = load_tyre(), 0.07
    profile = np.cumsum(np.random.default_rng(seed).normal(0.0, 0.004, 200))
    heights, origin = _grid(profile)
    height, slope = envelope_reference(heights[0].astype(float), SPACING, tyre, half)
    for i in range(30, 170):
        got = effective_plane(heights, origin, cam(tyre), i * SPACING, 0.0, 1.0, 0.0, half)
        assert got[0] == pytest.approx(height[i], abs=1e-6)
        assert got[1] == pytest.approx(slope[i], abs=2e-5)
        assert got[2] == pytest.approx(0.0, abs=1e-6)


def test_enveloping_of_an_inclined_plane_is_that_plane():
    slope = 0.08
    heights, origin = _grid(slope * SPACING * np.arange(200))
    tyre = load_tyre()
    height, along, _ = effective_plane(heights, origin, cam(tyre), 5.0, 0.0, 1.0, 0.0, 0.07)
    assert along == pytest.approx(slope, rel=1e-5)
    lift = height - slope * 5.0  # an elliptic cam touches a plane a little ahead of its lowest point
    assert 0.0 <= lift < 2e-4
    back = effective_plane(heights, origin, cam(tyre), 5.0, 0.0, -1.0, 0.0, 0.07)
    assert back[1] == pytest.approx(-slope, rel=1e-5)


def test_a_step_is_felt_before_the_axle_reaches_it_and_smoothed():
    profile = np.where(np.arange(200) >= 100, 0.02, 0.0)
    height, _ = envelope_reference(profile, SPACING, load_tyre(), 0.07)
    first = int(np.argmax(height > 1e-4))
    assert 95 <= first < 100
    assert np.all(np.diff(height[40:160]) >= -1e-12)


@pytest.mark.parametrize("name", tyre_names())
def test_power_of_the_contact_is_load_work_plus_losses(name):
    """F.v + M.w on the belt = -(slip loss + drag loss): what the car loses is what the table of work says."""
    tyre = load_tyre(name)
    radius = 0.92 * tyre.r0
    for spin in (18.0 / radius, 20.0 / radius, 23.0 / radius):
        out, wrench, _, _ = _wheel(height=radius, speed=20.0, spin=spin, fz_steps=200, sideways=0.4, tyre=tyre)
        power = wrench[0] * 20.0 + wrench[1] * 0.4 + wrench[4] * spin
        assert power == pytest.approx(-(out["slip_loss"] + out["drag_loss"]), rel=1e-9)
        assert out["drag_loss"] > 0.0
        assert out["slip_loss"] >= 0.0


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
                rng.normal(0, 0.02), rng.normal(0, 20, 3), rng.normal(0, 100), axis, rng.uniform(0, 500e3), 1.0,
                rng.uniform(0.05, 1.5), rng.choice([-1.0, 1.0]), STEP,
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

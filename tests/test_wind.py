"""Claims about wind: its force, its gusts' spectrum; about a worn tyre; about the country road."""

from __future__ import annotations

import math

import numpy as np
import pytest

from models.tyre_properties import load_tyre
from models.vehicle import AIR_DENSITY
from testbed.campaign.fields import scenario_from
from testbed.campaign.variants import scaled
from testbed.manoeuvres.country import LATERAL, LEVELS, Country
from testbed.scenario import Scenario
from testbed.tyre.wear import DENSITY, LAND, worn_factors
from testbed.wind import LENGTH, STEP, wind_series
from tests.drives import drive

KMH = 1.0 / 3.6
FORCE_TOLERANCE = 0.02  # of a force read off a drive: toe, slip and the tyres' drag shift with it
PATH_TOLERANCE = 0.5  # m that a side wind of 20 m/s may push the car aside: the driver has no integral
SAMPLES = 200_000  # of a series: its standard deviation is then known to 1 %


@pytest.mark.parametrize("coming_from", [0.0, math.pi])
def test_head_and_tail_wind_change_the_drag_by_the_square_of_the_air_speed(coming_from):
    fields = {"road": "flat", "speed": 100 * KMH, "duration": 30.0}
    calm = drive(**fields)
    windy = drive(**fields, wind=10.0, wind_from=coming_from, gusts=0.0)
    late = slice(25000, None)
    extra = (windy["fx"] - calm["fx"])[late].sum(axis=1).mean()
    body = calm.simulation.vehicle.chassis
    through = 100 * KMH + 10.0 * math.cos(coming_from)
    area = 0.5 * AIR_DENSITY * body.frontal_area * body.drag_coefficient
    assert extra == pytest.approx(area * (through**2 - (100 * KMH) ** 2), rel=FORCE_TOLERANCE)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_side_wind_is_held_by_the_tyres_and_acts_ahead_of_the_centre_of_gravity(side):
    """A wind from the left pushes to the right: the tyres' side forces add up to it, the front axle's share by the
    lever law."""
    fields = {"road": "flat", "speed": 100 * KMH, "duration": 10.0}
    calm, windy = drive(**fields), drive(**fields, wind=20.0, wind_from=side * 0.5 * math.pi, gusts=0.0)
    body, late = calm.simulation.vehicle.chassis, slice(8000, None)
    stream = math.hypot(100 * KMH, 20.0)
    pushed = -side * 0.5 * AIR_DENSITY * body.frontal_area * body.side_force_slope * stream * 20.0
    held = (windy["fy"] - calm["fy"])[late].mean(axis=0)
    assert held.sum() == pytest.approx(-pushed, rel=FORCE_TOLERANCE)
    base = body.cg_to_front_axle + body.cg_to_rear_axle
    front = (body.cg_to_rear_axle + body.pressure_point * (1.0 - body.drag_coefficient / body.side_force_slope)) / base
    assert held[:2].sum() / held.sum() == pytest.approx(front, abs=0.03)  # aligning moments shift a few per cent
    assert np.abs(windy["path_error"]).max() < PATH_TOLERANCE


def test_gusts_have_the_declared_spectrum():
    """Markov of first order: standard deviation, correlation over one length of the gusts, independent components."""
    series = wind_series(12.0, 0.7, 0.2, 25.0, SAMPLES * STEP, seed=3)
    gusts = series - [-12.0 * math.cos(0.7), -12.0 * math.sin(0.7)]
    through = math.hypot(25.0 + 12.0 * math.cos(0.7), 12.0 * math.sin(0.7))
    assert gusts.std(axis=0) == pytest.approx([2.4, 2.4], rel=0.03)
    lag = round(LENGTH / through / STEP)
    together = (gusts[lag:] * gusts[:-lag]).mean(axis=0) / gusts.var(axis=0)
    assert together == pytest.approx(math.exp(-lag * STEP * through / LENGTH), abs=0.03)
    assert abs(np.corrcoef(gusts.T)[0, 1]) < 0.03


def test_wind_comes_from_the_seed_and_no_wind_is_none():
    a, b, c = (wind_series(8.0, 0.0, 0.3, 20.0, 60.0, seed) for seed in (1, 1, 2))
    assert a.tobytes() == b.tobytes() != c.tobytes()
    assert not wind_series(0.0, 1.0, 0.3, 20.0, 60.0, 1).any()


def test_gusts_move_the_car_and_calm_air_does_not():
    calm = drive(road="flat", speed=120 * KMH, duration=6.0)
    gusty = drive(road="flat", speed=120 * KMH, duration=6.0, wind=10.0, wind_from=1.5, gusts=0.3)
    assert np.abs(gusty["gyro"][:, 2]).max() > 20.0 * np.abs(calm["gyro"][:, 2]).max()
    assert np.abs(gusty["path_error"]).max() < PATH_TOLERANCE


def test_campaign_fields_of_the_wind_are_the_scenarios():
    found = scenario_from({"wind_kmh": 36.0, "wind_from_deg": 90.0, "gust_percent": 25.0})
    assert (found.wind, found.wind_from, found.gusts) == pytest.approx((10.0, 0.5 * math.pi, 0.25))
    assert Scenario.from_notes(found.as_notes()) == found


def test_worn_tyre_is_lighter_by_its_tread_and_smaller_on_the_same_sidewall():
    tyre = load_tyre()
    factors, radius = worn_factors(tyre, 3e-3)
    worn = scaled(tyre, factors, "tyre")
    gone = 2.0 * math.pi * tyre.r0 * tyre.width * LAND * DENSITY * 5e-3
    assert tyre.belt_mass - worn.belt_mass == pytest.approx(gone)
    assert radius == pytest.approx(1.0 - 5e-3 / tyre.r0)
    for name in ("sidewall_stiffness", "lateral_sidewall_stiffness", "torsional_stiffness"):
        assert getattr(worn, name) == pytest.approx(getattr(tyre, name))
    assert worn_factors(tyre, 8e-3) == (dict.fromkeys(factors, 1.0), 1.0)
    with pytest.raises(ValueError, match=r"tread depth 1 mm is out of range; valid: 1.6 to 8 mm"):
        worn_factors(tyre, 1e-3)


@pytest.mark.parametrize("speed", [60 * KMH, 100 * KMH])
def test_country_road_bends_left_and_right_within_its_lateral_acceleration(speed):
    plan = Country().plan(speed, 120.0)
    lateral = speed**2 * plan.path[:, 3]
    assert lateral.max() == pytest.approx(max(LATERAL), rel=1e-6)
    assert -lateral.min() == pytest.approx(max(LATERAL), rel=1e-6)
    assert np.abs(plan.path[:, 2]).max() < 0.5 * np.pi  # it goes on along x
    assert plan.speed[:12000].min() == pytest.approx(min(LEVELS) * speed, rel=0.01)
    assert plan.speed.max() == pytest.approx(max(LEVELS) * speed, rel=0.01)

"""Claims about energy: what a coasting car loses is what the air, the tyres and the dampers take."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from models.vehicle import AIR_DENSITY
from testbed.simulation import Simulation
from testbed.trace import WORK
from testbed.tyre import vertical
from tests.drives import Driven, drive, settled

KMH = 1.0 / 3.6
BALANCE_TOLERANCE = 0.02  # what the joints' own dampers and the held forces of a 1 ms step leave out
DRAG_TOLERANCE = 0.01


def stored_energy(car: Simulation) -> float:
    """Kinetic and potential energy of the whole car [J]: MuJoCo's own sum over every body, wheel rotation included,
    with gravity and the springs that are joints; plus struts and tyres, whose forces the loop applies."""
    data = mujoco.MjData(car.model)
    data.qpos[:], data.qvel[:] = car.data.qpos, car.data.qvel
    mujoco.mj_forward(car.model, data)
    mujoco.mj_energyVel(car.model, data)
    mujoco.mj_energyPos(car.model, data)
    s, law = car.constants.suspension, car.element.law
    x = car.data.qpos[car.index.travel_q]
    struts = s.preload * x + 0.5 * s.rate * x**2 + 0.25 * s.progression * x**4
    load, pressure = car.state.outputs[:, 0], car.state.gas[:, 2]
    cz = [vertical.mean_stiffness(law, p, data.qvel[0] / law.r0, f) for p, f in zip(pressure, load, strict=True)]
    sidewall = car.element.sidewall * np.array([vertical.pressure_factor(law, p) for p in pressure])
    tyres = 0.5 * load**2 * (1.0 / np.array(cz) - 1.0 / sidewall)  # the sidewall's share is a joint spring
    return float(data.energy.sum() + struts.sum() + tyres.sum())


@pytest.mark.parametrize(
    "fields",
    [
        {"road": "flat", "speed": 100 * KMH, "manoeuvre": "coast", "duration": 20.0},
        {"road": "C", "speed": 60 * KMH, "manoeuvre": "coast", "duration": 20.0},
        {"road": "flat", "speed": 60 * KMH, "manoeuvre": "coast", "duration": 10.0, "grade": 0.05},
        {"road": "flat", "speed": 100 * KMH, "manoeuvre": "brake", "duration": 8.0},
        {"road": "flat", "speed": 50 * KMH, "manoeuvre": "stops", "duration": 18.0},
    ],
    ids=["coast flat", "coast class C", "coast uphill", "brake", "pull away"],
)
def test_energy_lost_is_the_work_done(fields, claim):
    car = settled(**fields)
    before = stored_energy(car)
    run = Driven(car)
    change = stored_energy(car) - before
    work = dict(zip(WORK, run["work"][-1], strict=True))
    assert min(work.values()) >= 0.0  # each sink takes, the engine gives
    given = work.pop("drive")
    error = abs(change / (given - sum(work.values())) - 1.0)
    what = "energy balance: coasting, uphill, braking, pulling away"
    claim(what, 100.0 * error, 100.0 * BALANCE_TOLERANCE, "%")


def test_each_work_term_belongs_to_its_cause():
    """Flat and coasting: no brake and no strut work; engine work only while its torque dies out (0.05 s)."""
    run = drive(road="flat", speed=100 * KMH, manoeuvre="coast", duration=10.0)
    work = dict(zip(WORK, run["work"][-1], strict=True))
    total = work["air"] + work["rolling"]
    assert work["brake"] == 0.0
    assert work["strut"] < 1e-4 * total
    assert work["slip"] < 1e-2 * total
    assert work["drive"] < 1e-2 * total
    assert work["drive"] == pytest.approx(run["work"][1000, WORK.index("drive")], rel=1e-6)


def test_coast_down_deceleration_is_drag_over_effective_mass(claim):
    """a = (F_air + F_roll) / (m + sum J / Re^2); F_roll = sum My / Re."""
    run = drive(road="flat", speed=100 * KMH, manoeuvre="coast", duration=10.0)
    car, tyre = run.simulation.vehicle, run.simulation.tyre
    late = slice(2000, 10000)
    speed, radius = run["velocity"][late, 0], run["rolling_radius"][late].mean()
    air = 0.5 * AIR_DENSITY * car.chassis.frontal_area * car.chassis.drag_coefficient * speed**2
    rolling = run["drag_moment"][late].sum(axis=1) / radius
    turning = sum(axle.spin_inertia + tyre.belt_iyy for axle in car.axles) / radius**2
    slowing = (speed[0] - speed[-1]) / (run["time"][late][-1] - run["time"][late][0])
    error = abs(slowing / ((air + rolling).mean() / (car.mass + turning)) - 1.0)
    claim("coast-down deceleration against drag over effective mass", 100.0 * error, 100.0 * DRAG_TOLERANCE, "%")


def test_rolling_resistance_is_the_published_moment():
    """MF 6.1: My = R0 Fz0 (QSY1 + QSY3 v/V0 + QSY4 (v/V0)^4) (Fz/Fz0)^QSY7 at p0, read off the drive."""
    run = drive(road="flat", speed=100 * KMH, manoeuvre="coast", duration=2.0)
    t = run.simulation.tyre
    v, fz = run["velocity"][-1, 0] / t.v0, run["load"][-1]
    moment = t.r0 * t.fz0 * (t.qsy1 + t.qsy3 * v + t.qsy4 * v**4) * (fz / t.fz0) ** t.qsy7
    warmth = (run["pressure"][-1] / t.p0) ** t.qsy8
    assert run["drag_moment"][-1] == pytest.approx(moment * warmth, rel=1e-3)

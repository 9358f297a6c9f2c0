"""A drive's physics from a scenario: car, tyres and road put together, settled, and advanced second by second.

simulation = Simulation(scenario)
for stretch in simulation.stretches():   # about a second each, until the duration is reached
    ...
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
from numpy.typing import NDArray

from estimators.drive_log import WHEELS
from models.car import RoadGrid, compile_model, compose
from models.tyre_properties import TyreProperties, load_tyre
from models.vehicle import AIR_DENSITY, GRAVITY, Payload, Vehicle, load_vehicle
from testbed import driver, loop, trace
from testbed.brake_pull import pull_plan
from testbed.driver import driver_car
from testbed.loop import Constants, Index, State, Views
from testbed.manoeuvres.manoeuvre import find_manoeuvre
from testbed.native import address
from testbed.roads import make_road
from testbed.roads.friction import parse_friction
from testbed.roads.window import RoadWindow
from testbed.scenario import Scenario
from testbed.steering.active_steering import NO_FAULT, SteeringUnit, steering_state, steering_unit
from testbed.steering.loop_fault import loop_fault
from testbed.suspension import suspension
from testbed.tyre import contact, vertical
from testbed.tyre.contact import tyre_element
from testbed.tyre.inflation import inflation, initial_gas
from testbed.wind import wind_series

STRETCH = 1.0  # s of one stretch
POSE_RATE = 40.0  # Hz of the poses that are recorded
RUN_IN = 3.0  # m between the car's start and the road's: the road is flat there
SETTLING = 4.0  # s on the run-in before the clock starts: a payload's body motion has died out by then


class Diverged(ValueError):
    """The drive left the range in which its physics means anything."""


@dataclass(frozen=True)
class Stretch:
    """Trace rows (n, WIDTH) and body poses: times (m,), position and quaternion wxyz (m, bodies, 7)."""

    rows: NDArray[np.float64]
    pose_time: NDArray[np.float64]
    poses: NDArray[np.float64]

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        return trace.column(self.rows, name)


def nominal_radius(vehicle: Vehicle, tyre: TyreProperties) -> float:
    """Rolling radius at the static mean load, nominal pressure and 80 km/h [m]: what the car's maker writes down."""
    fz = 0.25 * vehicle.mass * GRAVITY
    return float(vertical.effective_rolling_radius(vertical.vertical_law(tyre), 80.0 / 3.6 / tyre.r0, fz, tyre.p0))


def radius_sensitivity(tyre: TyreProperties) -> float:
    """d ln(rolling radius) / d pressure at the tyre's nominal pressure, load and speed [1/Pa]."""
    law, step = vertical.vertical_law(tyre), 0.01 * tyre.p0
    low, high = (
        vertical.effective_rolling_radius(law, tyre.v0 / tyre.r0, tyre.fz0, tyre.p0 + sign * step) for sign in (-1, 1)
    )
    return float(np.log(high / low) / (2.0 * step))


def tyre_law(vehicle: Vehicle, tyre: TyreProperties) -> dict[str, float]:
    """The vertical stiffness law that the car's maker writes down, by the fields of `Car`: at rest, nominal pressure
    and the mean static load, with its changes by pressure, speed and load there."""
    law, fz, fast = vertical.vertical_law(tyre), 0.25 * vehicle.mass * GRAVITY, 80.0 / 3.6
    rest = vertical.mean_stiffness(law, tyre.p0, 0.0, fz)
    low, high = (vertical.mean_stiffness(law, (1.0 + share) * tyre.p0, 0.0, fz) for share in (-0.4, 0.0))
    loaded = vertical.mean_stiffness(law, tyre.p0, 0.0, 1.1 * fz)
    return {
        "tyre_stiffness": rest,
        "tyre_stiffness_per_pressure": (high - low) / (0.4 * rest),
        "tyre_stiffness_per_speed": (vertical.mean_stiffness(law, tyre.p0, fast / tyre.r0, fz) / rest - 1.0) / fast,
        "tyre_stiffness_per_load": math.log(loaded / rest) / math.log(1.1),
    }


def tyre_footprint(vehicle: Vehicle, tyre: TyreProperties) -> float:
    """Distance of the enveloping cams at the mean static load and nominal pressure [m]."""
    fz = 0.25 * vehicle.mass * GRAVITY
    return float(2.0 * tyre.ellips_shift * vertical.contact_half_length(vertical.vertical_law(tyre), 1.0, fz))


class Simulation:
    """One drive. Everything random in it comes from the scenario's seed."""

    def __init__(self, scenario: Scenario, vehicle: Vehicle | None = None, tyre: TyreProperties | None = None) -> None:
        """vehicle, tyre: in place of the ones that the scenario names (a study's variant)."""
        self.scenario = scenario
        self.vehicle = vehicle or load_vehicle()
        self.tyre = tyre or load_tyre(scenario.tyre)
        plan = find_manoeuvre(scenario.manoeuvre).plan(scenario.speed, scenario.duration)
        fastest = max(float(plan.speed.max()), 1.0)
        self.road = make_road(
            scenario.road, scenario.seed, fastest, scenario.duration,
            grade=scenario.grade, bank=scenario.bank, obstacles=scenario.obstacles,
        )  # fmt: skip
        self.window = RoadWindow(self.road)
        grid = RoadGrid(self.window.nx, self.window.ny, self.window.spacing)
        self.payload = Payload(scenario.payload, scenario.payload_position)
        self.model = compile_model(compose(self.vehicle, self.tyre, self.payload, grid, scenario.step))
        self.data = mujoco.MjData(self.model)
        self.index = _index(self.model)
        self.element = tyre_element(self.tyre)
        self.constants = self._constants(plan)
        self.state = self._state(float(plan.speed[0]))
        self.window.attach(self.model, "road")
        self.views = _views(self.model, self.data)
        self._start(float(plan.speed[0]))

    @cached_property
    def pressures(self) -> NDArray[np.float64]:
        """Pressure of each tyre at the start [Pa], shape (4,)."""
        return np.array([self.scenario.pressures.get(w, self.tyre.p0) for w in WHEELS], float)

    @property
    def nominal_radius(self) -> float:
        """See the function of that name [m]."""
        return nominal_radius(self.vehicle, self.tyre)

    def _constants(self, plan: driver.Plan) -> Constants:
        s, body = self.scenario, self.vehicle.chassis
        grip = parse_friction(s.friction)
        area = 0.5 * AIR_DENSITY * body.frontal_area
        return Constants(
            step=s.step,
            tyre=self.element,
            suspension=suspension(self.vehicle),
            driver=driver_car(self.vehicle, self.tyre, self.payload, self.nominal_radius, s.driven),
            plan=plan,
            inflation=inflation(self.tyre, s.leaks, s.pressure_sets, s.ambient),
            pulls=pull_plan(s.brake_pulls),
            friction_edges=grip.edges,
            friction_left=grip.left,
            friction_right=grip.right,
            radius_factor=np.array([s.radius_factor.get(w, 1.0) for w in WHEELS]),
            spin_inertia=np.array([axle.spin_inertia for axle in self.vehicle.axles]),
            drag_area=area * body.drag_coefficient,
            side_area=area * (body.side_force_slope - body.drag_coefficient),
            pressure_point=body.pressure_point,
            wind=wind_series(s.wind, s.wind_from, s.gusts, float(plan.speed.mean()), s.duration, s.seed),
            steering_ratio=self.vehicle.driveline.steering_ratio,
            active_steering=self._steering_unit(),
        )

    def _steering_unit(self) -> SteeringUnit:
        s = self.scenario
        wrong = loop_fault(s.faults, s.seed, s.duration) if s.faults_in_loop else NO_FAULT
        return steering_unit(self.vehicle.active_steering, s.active_steering, s.step, s.steering_lock, wrong)

    def _state(self, speed: float) -> State:
        steering = steering_state(speed)
        return State(
            clock=np.zeros(1, np.int64),
            driver=np.zeros(driver.STATE_SIZE),
            tyres=np.zeros((4, len(contact.STATE))),
            gas=initial_gas(self.pressures, self.scenario.ambient),
            leak_span=np.zeros(4),
            bristle=np.zeros(4),
            outputs=np.zeros((4, len(contact.OUTPUT))),
            work=np.zeros(len(trace.WORK)),
            steering_motor=steering.motor,
            steering_control=steering.control,
            steering_unit=steering.unit,
        )

    def _start(self, speed: float) -> None:
        """Puts the car on the run-in at a speed [m/s] and lets it settle there, with the clock below zero."""
        step = self.scenario.step
        settling = round(SETTLING / step)
        law, q, v = self.element.law, self.data.qpos, self.data.qvel
        q[0] = -RUN_IN - speed * settling * step
        v[0] = speed
        self.state.driver[driver.STATION] = q[0]
        for w in range(4):
            load = self.vehicle.static_wheel_load()[w // 2]
            omega = speed / vertical.effective_rolling_radius(law, speed / law.r0, load, self.pressures[w])
            v[self.index.spin_v[w]] = omega
            v[self.model.joint(f"{WHEELS[w]}/belt_spin").dofadr[0]] = omega
        self.state.driver[driver.GEAR] = np.searchsorted(self.constants.driver.upshift, speed)
        self.state.clock[0] = -settling
        self.window.follow(q[0], q[1])
        self._advance(settling)
        self.state.work[:] = 0.0

    def _advance(self, steps: int) -> Stretch:
        """`steps` steps on. ValueError (Diverged) if the car rolls over or leaves the physics."""
        rows: NDArray[np.float64] = np.empty((steps, trace.WIDTH))
        stride = max(round(1.0 / (POSE_RATE * self.scenario.step)), 1)
        poses = np.empty((steps // stride + 1, self.model.nbody, 7))
        first, done, taken = int(self.state.clock[0]), 0, 0
        while done < steps:
            self.window.follow(self.data.qpos[0], self.data.qpos[1])
            end, driven, posed = loop.run(
                self.views, self.index, self.constants, self.state, self.window.heights, self.window.origin,
                self.window.room, rows[done:], poses[taken:], stride,
            )  # fmt: skip
            done, taken = done + driven, taken + posed
            if end in (loop.DIVERGED, loop.ROLLED_OVER):
                raise self._diverged("the car rolled over" if end == loop.ROLLED_OVER else "the drive diverged")
        ticks = -(-first // stride) * stride + stride * np.arange(taken, dtype=np.float64)
        return Stretch(rows, ticks * self.scenario.step, poses[:taken])

    def _diverged(self, what: str) -> Diverged:
        s = self.scenario
        time = self.state.clock[0] * s.step
        when = f"at {time:.3f} s" if time >= 0.0 else "before the start, on level ground"
        asked = [f"road {s.road} at {3.6 * s.speed:g} km/h"]
        asked += [f"{s.payload:g} kg at {list(s.payload_position)} m"] if s.payload else []
        asked += [f"grade {s.grade:g} and bank {s.bank:g}"] if s.grade or s.bank else []
        asked += list(s.obstacles)
        return Diverged(f"{what} {when}: {', '.join(asked)} is more than it can take; less of it is valid")

    def stretches(self) -> Iterator[Stretch]:
        """The drive in stretches of about STRETCH seconds, from the clock's present time to the scenario's duration."""
        total = round(self.scenario.duration / self.scenario.step)
        size = round(STRETCH / self.scenario.step)
        while self.state.clock[0] < total:
            yield self._advance(min(size, total - int(self.state.clock[0])))


def _views(model: mujoco.MjModel, data: mujoco.MjData) -> Views:
    return Views(
        address("mj_step1"), address("mj_step2"), model._address, data._address,
        data.qpos, data.qvel, data.xpos, data.xquat, data.xmat, data.cvel, data.subtree_com, data.xfrc_applied,
        data.qfrc_applied, data.sensordata, model.jnt_stiffness, model.tendon_stiffness, model.qpos_spring,
    )  # fmt: skip


def _index(model: mujoco.MjModel) -> Index:
    def each(find) -> NDArray[np.int64]:
        return np.array([int(np.atleast_1d(find(w))[0]) for w in WHEELS], np.int64)

    return Index(
        chassis=int(model.body("chassis").id),
        knuckle=each(lambda w: model.body(f"{w}/knuckle").id),
        rim=each(lambda w: model.body(f"{w}/rim").id),
        belt=each(lambda w: model.body(f"{w}/belt").id),
        travel_q=each(lambda w: model.joint(f"{w}/travel").qposadr),
        travel_v=each(lambda w: model.joint(f"{w}/travel").dofadr),
        steer_q=each(lambda w: model.joint(f"{w}/steer").qposadr),
        spin_q=each(lambda w: model.joint(f"{w}/spin").qposadr),
        spin_v=each(lambda w: model.joint(f"{w}/spin").dofadr),
        belt_x=each(lambda w: model.joint(f"{w}/belt_x").id),
        belt_z=each(lambda w: model.joint(f"{w}/belt_z").id),
        torsion=each(lambda w: model.tendon(f"{w}/torsion").id),
        hub_accel=each(lambda w: model.sensor(f"{w}/accel").adr),
        body_accel=each(lambda w: model.sensor(f"body_{w}").adr),
        accel=int(model.sensor("imu_accel").adr[0]),
        gyro=int(model.sensor("imu_gyro").adr[0]),
    )

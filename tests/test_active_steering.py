"""Claims about the active front steering: gear and rack in closed form, the servo against an integration of its own,
limits, energy, the lock, and what a car with it does and logs."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from estimators.faults import inject
from estimators.readers import read_log
from models.vehicle import load_vehicle
from testbed.drive import main
from testbed.scenario import Scenario
from testbed.session import Session
from testbed.steering import gear, motor, ratio, servo
from testbed.steering.active_steering import HAND_RATE, advance, steering_state, steering_unit
from testbed.steering.loop_fault import loop_fault
from testbed.study.steering_actuator.scenarios import BRISK, CALM, CASES, SET_A
from testbed.trace import column
from tests.drives import Driven, drive

NUMBERS = load_vehicle().active_steering
UNIT = steering_unit(NUMBERS, True, 1e-3)
STEP, DEGREE = 1e-3, math.pi / 180.0
EXACT = 1e-12  # rounding of angles of some rad
SERVO_TOLERANCE = 0.003  # of a step's size: the motor in quarters of a millisecond against a tight integration
ENERGY_TOLERANCE = 0.01  # of the energy fed in: the same, summed by the trapezoidal rule
# deg: five deviations of the noise and a step; of the demand half a step; of the pinion three deviations of its zero
SENSOR_ERRORS = {"motor_angle": 1.6, "motor_demand": 0.012, "pinion_angle": 1.3}
RAPID = {"manoeuvre": "rapid-steering", "speed": 16.0 / 3.6, "duration": 5.0, "road": "flat", "active_steering": True}


@pytest.fixture(scope="module")
def rapid() -> Driven:
    """Rapid steering at the speed of the largest residuals, with active steering."""
    return drive(**RAPID)


def test_gear_and_rack_are_inverted_exactly() -> None:
    """Equation 1.1 there and back, F_SG there and back up to the rack's end, rising throughout."""
    g = UNIT.gear
    for wheel, turned in ((0.3, 100.0), (-7.0, 40.0), (2.0, 0.0)):
        pinion = gear.pinion_of(g, wheel, turned)
        assert pinion == pytest.approx(wheel / NUMBERS.wheel_ratio + turned / NUMBERS.motor_ratio, abs=EXACT)
        assert gear.steering_wheel_of(g, pinion, turned) == pytest.approx(wheel, abs=EXACT)
    angles = np.linspace(-NUMBERS.rack_stop, NUMBERS.rack_stop, 401)
    pinions = np.array([gear.pinion_for(g, a) for a in angles])
    assert (np.diff(pinions) > 0.0).all()
    assert np.array([gear.road_wheels_of(g, p) for p in pinions]) == pytest.approx(angles, abs=EXACT)
    assert gear.road_wheels_of(g, 2.0 * pinions[-1]) == pytest.approx(NUMBERS.rack_stop, abs=EXACT)
    assert gear.road_wheels_of(g, 1e-3) == pytest.approx(1e-3 / NUMBERS.rack_ratio, rel=1e-6)


def test_a_demand_that_is_met_gives_the_ratio_of_the_speed() -> None:
    """Steering wheel over road wheels, straight ahead: 10 when slow, 20 when fast, and at its node where the motor
    has nothing to add."""
    for speed, wanted in ((0.0, 10.0), (5.0, 10.0), (16.25, 13.0), (27.0, 18.0), (33.5, 20.0), (60.0, 20.0)):
        demand = ratio.motor_demand(UNIT.gear, UNIT.ratio, speed, 1e-3)
        road = gear.road_wheels_of(UNIT.gear, gear.pinion_of(UNIT.gear, 1e-3, demand))
        assert 1e-3 / road == pytest.approx(wanted, rel=1e-6)
    assert ratio.motor_demand(UNIT.gear, UNIT.ratio, 27.0, 1.0) == pytest.approx(0.0, abs=EXACT)


def servo_run(demand: np.ndarray, load: float = 0.0) -> np.ndarray:
    """Motor angle, speed, current and the current asked for, one row a millisecond, without the sensor's steps."""
    state, rows = steering_state(0.0), []
    for wanted in demand:
        asked = servo.control(UNIT.servo, state.control, wanted, state.motor[motor.ANGLE])
        rows.append([*state.motor, asked])
        motor.motor_step(UNIT.motor, state.motor, asked, load, STEP)
    return np.array(rows)


def integrated_run(demand: np.ndarray, load: float) -> np.ndarray:
    """Angle of the same servo: the control written out anew, the motor as differential equations for scipy."""
    n, angle, speed, current = NUMBERS, 0.0, 0.0, 0.0
    sensed, rate, integral, found = 0.0, 0.0, 0.0, []

    def slopes(_: float, x: np.ndarray, asked: float) -> list[float]:
        high = min(n.largest_current, (n.supply_voltage - n.torque_constant * x[1]) / n.resistance)
        low = max(-n.largest_current, (-n.supply_voltage - n.torque_constant * x[1]) / n.resistance)
        rub = n.motor_friction * math.tanh(x[1] / 0.01)
        torque = n.torque_constant * x[2] - n.motor_damping * x[1] - load - rub
        return [x[1], torque / n.motor_inertia, (min(max(asked, low), high) - x[2]) / n.current_lag]

    for wanted in demand:
        rate += ((angle - sensed) / STEP - rate) * (1.0 - math.exp(-1.0))  # smoothed over a millisecond
        sensed = angle
        error = float(np.clip(n.position_gain * (wanted - angle), -n.largest_speed, n.largest_speed)) - rate
        gain = n.velocity_gain * n.motor_inertia / n.torque_constant
        asked = gain * (error + n.velocity_integral * integral)
        if abs(asked) < n.largest_current or asked * error < 0.0:
            integral += error * STEP
        asked = float(np.clip(asked, -n.largest_current, n.largest_current))
        found.append(angle)
        run = solve_ivp(
            slopes, (0.0, STEP), [angle, speed, current], args=(asked,), method="LSODA", rtol=1e-6, atol=1e-8
        )
        angle, speed, current = run.y[:, -1]
    return np.array(found)


@pytest.mark.parametrize(("size", "load"), [(60.0, 0.1), (150.0, 0.75), (-2.0, 0.0)])
def test_servo_answers_a_step_as_an_integration_of_its_own_does(size: float, load: float) -> None:
    """A large step runs into current and speed, against a heavy load into the voltage; a small one into none of
    them."""
    demand = np.full(900 if load > 0.5 else 300, size)
    here, there = servo_run(demand, load)[:, 0], integrated_run(demand, load)
    assert np.abs(here - there).max() < SERVO_TOLERANCE * abs(size)
    assert here[-1] == pytest.approx(size, rel=0.02)


def test_servo_runs_behind_a_steady_demand_by_its_speed_over_the_gain() -> None:
    rate = 50.0
    demand = rate * np.arange(600) * STEP
    lag = demand[-1] - servo_run(demand)[-1, 0]
    assert lag == pytest.approx(rate / NUMBERS.position_gain, rel=0.01)


def test_limits_hold_and_energy_is_conserved() -> None:
    """Current within its bound, speed below no load; electric work = copper + friction + damping + load + motion."""
    time = np.arange(2000) * STEP
    demand = 90.0 * np.sin(2.0 * np.pi * 1.5 * time) + 20.0 * np.sign(np.sin(2.0 * np.pi * 4.0 * time))
    load, n = 0.1, NUMBERS
    _, speed, current, _ = servo_run(demand, load).T
    assert np.abs(current).max() <= n.largest_current
    assert np.abs(current).max() > 0.99 * n.largest_current  # it did come there
    assert np.abs(speed).max() < n.supply_voltage / n.torque_constant
    mid_speed, mid_current = 0.5 * (speed[1:] + speed[:-1]), 0.5 * (current[1:] + current[:-1])
    work = n.torque_constant * np.sum(mid_current * mid_speed) * STEP
    spent = np.sum(n.motor_friction * np.abs(mid_speed) + n.motor_damping * mid_speed**2 + load * mid_speed) * STEP
    kept = 0.5 * n.motor_inertia * speed[-1] ** 2
    fed = np.sum(np.abs(n.torque_constant * mid_current * mid_speed)) * STEP
    assert abs(work - spent - kept) < ENERGY_TOLERANCE * fed
    electric = n.resistance * current**2 + n.torque_constant * current * speed
    assert electric.max() < 1.05 * n.supply_voltage * n.largest_current  # the network's power; the current lags


def test_the_plain_car_has_none_of_it() -> None:
    """No figure of the active steering matters to the last bit, and none of its columns is filled."""
    v = load_vehicle()
    other = dataclasses.replace(v, active_steering=dataclasses.replace(NUMBERS, rack_ratio=9.0, position_gain=7.0))
    fields = {"manoeuvre": "slalom", "speed": 12.0, "duration": 2.0}
    plain, odd = drive(**fields), drive(vehicle=other, **fields)
    assert np.array_equal(plain.rows, odd.rows)
    for name in ("motor_angle", "motor_speed", "motor_torque", "motor_demand", "pinion_angle", "motor_locked"):
        assert not plain[name].any()


def test_with_it_the_car_takes_the_same_way_with_less_work_at_the_wheel() -> None:
    """Slalom at a constant 40 km/h: path within 2 cm and the steering wheel turned by the ratio, 10.9 to 16."""
    fields = {"manoeuvre": "slalom", "speed": 40.0 / 3.6, "duration": 6.0, "road": "flat"}
    plain, active = drive(**fields), drive(**fields, active_steering=True)
    assert np.abs(plain["position"][:, :2] - active["position"][:, :2]).max() < 0.02
    wanted = ratio.ratio_at(UNIT.ratio, 40.0 / 3.6) / load_vehicle().driveline.steering_ratio
    assert np.ptp(active["steering_wheel"]) / np.ptp(plain["steering_wheel"]) == pytest.approx(wanted, rel=0.02)


def test_road_wheels_get_what_gear_and_motor_really_give(rapid: Driven) -> None:
    """Equation 1.1 and F_SG on the trace; hands, current and speed within their limits in the hardest drive."""
    pinion = rapid["steering_wheel"] / NUMBERS.wheel_ratio + rapid["motor_angle"] / NUMBERS.motor_ratio
    assert rapid["pinion_angle"] == pytest.approx(pinion, abs=EXACT)
    road = np.arcsin(np.clip(pinion / NUMBERS.rack_ratio, -math.sin(NUMBERS.rack_stop), math.sin(NUMBERS.rack_stop)))
    assert rapid["road_wheel_angle"] == pytest.approx(road, abs=EXACT)
    assert np.abs(np.diff(rapid["steering_wheel"])).max() <= HAND_RATE * STEP * (1.0 + 1e-9)
    assert np.abs(rapid["motor_torque"]).max() <= NUMBERS.torque_constant * NUMBERS.largest_current * (1.0 + 1e-9)
    assert np.abs(rapid["motor_speed"]).max() < NUMBERS.supply_voltage / NUMBERS.torque_constant
    turned = np.gradient(rapid["motor_angle"], STEP)
    assert np.abs(turned - rapid["motor_speed"]).max() < 0.01 * np.abs(turned).max()


def test_residuals_are_as_large_as_published(rapid: Driven) -> None:
    """Near +-1000 deg of the motor in rapid steering, within 40 deg in ordinary driving, most of them small."""
    residual = (rapid["motor_angle"] - rapid["motor_demand"]) / DEGREE
    assert 700.0 < np.abs(residual).max() < 1300.0
    assert np.median(np.abs(residual)) < 50.0
    calm = drive(manoeuvre="double-lane-change", speed=60.0 / 3.6, duration=4.0, road="B", active_steering=True)
    residual = (calm["motor_angle"] - calm["motor_demand"]) / DEGREE
    assert 10.0 < np.abs(residual).max() < 40.0


def test_a_locked_motor_stays_and_the_driver_steers_by_the_gear() -> None:
    lock = 3.4  # on the way to the slalom's first turn back
    run = drive(**{**RAPID, "manoeuvre": "slalom", "speed": 5.0, "steering_lock": lock})
    time, held = run["time"], run["time"] > lock + NUMBERS.lock_delay
    assert np.ptp(run["motor_angle"][held]) == 0.0
    assert abs(run["motor_angle"][held][0]) > 1.0  # it does not stand at its middle
    assert (run["motor_locked"] == held).mean() > 1.0 - 2.0 / len(time)
    moved = np.diff(run["pinion_angle"][held]) - np.diff(run["steering_wheel"][held]) / NUMBERS.wheel_ratio
    assert np.abs(moved).max() < EXACT
    assert np.abs(run["path_error"][held]).max() < 0.1


def test_the_pin_holds_whatever_pulls_and_without_current_the_motor_gives_way() -> None:
    """A moment twenty times a hard turn's, above what friction holds."""
    for lock, stays in ((0.0, True), (0.5, False)):
        unit, state = steering_unit(NUMBERS, True, STEP, lock), steering_state(0.0)
        for k in range(200):
            advance(unit, state, 0.0, 2e4, NUMBERS.lock_delay + k * STEP, STEP)
        assert (state.motor[motor.ANGLE] == 0.0) == stays
        assert stays or state.motor[motor.ANGLE] > 1.0  # a moment to the left turns to the left


def test_locked_from_the_start_it_is_a_plain_steering() -> None:
    fields = {"manoeuvre": "slalom", "speed": 10.0, "duration": 3.0, "road": "flat"}
    plain, locked = drive(**fields), drive(**fields, active_steering=True, steering_lock=0.0)
    assert np.abs(plain["position"] - locked["position"]).max() < 1e-6
    assert not locked["motor_angle"][100:].any()


def test_aligning_moments_load_the_motor() -> None:
    """In a steady circle the motor holds its share of the moment, less what friction holds."""
    run = drive(manoeuvre="circle", speed=12.0, duration=9.0, road="flat", active_steering=True)
    moment = run["mz"][-500:, :2].sum(axis=1).mean()
    slope = 1.0 / (NUMBERS.rack_ratio * math.cos(run["road_wheel_angle"][-1]))
    load = -(1.0 - NUMBERS.assist_share) * moment * slope / NUMBERS.motor_ratio
    assert 0.001 < load < NUMBERS.motor_friction  # it would turn the wheels back
    held = run["motor_torque"][-500:].mean()
    assert abs(held - load) <= NUMBERS.motor_friction


def test_a_log_holds_its_signals_and_a_fault_lies_over_them(tmp_path: Path) -> None:
    """The sensors say what is true within their errors; a fault of the drive is that over the sound log."""
    out = [tmp_path / f"{name}.rrd" for name in ("sound", "faulty")]
    what = "steering/motor_angle=bias:50@1"
    drive_of = ["--quiet", "--manoeuvre", "slalom", "--speed", "20", "--duration", "2.5", "--estimators", "none"]
    for path, more in zip(out, ([], ["--fault", what]), strict=True):
        assert main([*drive_of, "--active-steering", *more, "--out", str(path)]) == 0
    sound, faulty = (read_log(path) for path in out)
    for name, rate in (("motor_angle", 1000.0), ("motor_demand", 1000.0), ("pinion_angle", 100.0)):
        signal, truth = sound[f"steering/{name}"], sound[f"truth/steering/{name}"]
        assert signal.unit == "rad"
        assert np.diff(signal.time) == pytest.approx(1.0 / rate, abs=1e-6)
        late = 0.007 if rate == 100.0 else 0.0  # half of its mean's interval, and the bus
        error = np.interp(truth.time[20:-2] + late, signal.time, signal.value) - truth.value[20:-2]
        assert np.abs(error).max() < SENSOR_ERRORS[name] * DEGREE
    noise = np.diff(sound["steering/motor_angle"].between(0.0, 0.3).value).std() / math.sqrt(2.0)
    assert 0.2 * DEGREE < noise < 0.4 * DEGREE
    assert inject(sound, [what])["steering/motor_angle"] == faulty["steering/motor_angle"]
    assert sound["steering/pinion_angle"] == faulty["steering/pinion_angle"]


def test_inside_the_loop_a_biased_sensor_moves_the_motor_and_the_pinion_tells() -> None:
    bias, start = 50.0 * DEGREE, 1.0
    fields = {**RAPID, "manoeuvre": "constant", "duration": 2.0, "faults": ("steering/motor_angle=bias:50@1",)}
    outside, inside = drive(**fields), drive(**fields, faults_in_loop=True)
    late = outside["time"] > start + 0.5
    assert np.abs(outside["motor_angle"] - outside["motor_demand"])[late].max() < 3.0 * DEGREE
    assert inside["motor_angle"][late] == pytest.approx(inside["motor_demand"][late] - bias, abs=3.0 * DEGREE)
    turned = inside["pinion_angle"] - inside["steering_wheel"] / NUMBERS.wheel_ratio
    assert turned[late] == pytest.approx((inside["motor_demand"][late] - bias) / NUMBERS.motor_ratio, abs=0.1 * DEGREE)


def test_faults_of_the_loop_are_those_of_the_log() -> None:
    """bias over scale over drift by hand; the last value held where nothing comes."""
    text = [f"steering/motor_angle={what}" for what in ("bias:10@1-2", "scale:2@1.5", "drift:3@1", "stuck@2.5")]
    fault = loop_fault([*text, "imu/gyro=zero"], 3, 3.0)
    at = [500, 1200, 1700, 2200, 2700]
    assert fault.scale[at] == pytest.approx([1.0, 1.0, 2.0, 2.0, 2.0])
    assert fault.offset[at] / DEGREE == pytest.approx([0.0, 10.6, 22.1, 3.6, 5.1])
    assert fault.hold[at].tolist() == [0.0, 0.0, 0.0, 0.0, 1.0]
    with pytest.raises(ValueError, match="delay cannot act inside the loop"):
        loop_fault(["steering/motor_angle=delay:0.1"], 3, 3.0)


def test_who_asks_for_the_steering_angle_gets_what_turns_the_wheels() -> None:
    """In a slow slalom the driver's angle is off by the motor's share, the pinion's tells the road wheels'."""
    fields = {"manoeuvre": "slalom", "speed": 5.0, "duration": 5.0, "road": "flat", "active_steering": True}
    heard, truth = [], []
    with Session(Scenario(**fields), None, ["redundancy"]) as session:
        member = session.bank._members["redundancy"]
        update = member.update
        member.update = lambda given, until: (heard.append(given), update(given, until))[1]  # type: ignore[method-assign]
        truth = [stretch.rows for stretch, _ in session.run()]
    angle = np.concatenate([given["steering/angle"].value for given in heard])
    time = np.concatenate([given["steering/angle"].time for given in heard])
    rows = np.concatenate(truth)
    road = np.interp(time - 0.007, column(rows, "time"), column(rows, "road_wheel_angle"))
    car = session.bank._car
    assert np.abs(angle / car.steering_ratio - road).max() < SENSOR_ERRORS["pinion_angle"] * DEGREE / 15.0
    assert np.abs(column(rows, "steering_wheel") / car.steering_ratio - column(rows, "road_wheel_angle")).max() > 0.05


@pytest.mark.parametrize(
    ("fields", "names"),
    [
        ({"faults": ("steering/pinion_angle=zero",)}, "no active steering"),
        ({"steering_lock": 3.0}, "no active steering"),
        ({"faults_in_loop": True}, "no active steering"),
        ({"active_steering": 1}, "true or false"),
        ({"active_steering": True, "steering_lock": -1.0}, "0 s or later"),
        ({"sensors": {"steering/motor_angle": {"noise": 0.0}}}, "no sensor is named"),
    ],
)
def test_what_the_car_does_not_have_is_refused_in_one_line(fields: dict, names: str) -> None:
    with pytest.raises(ValueError, match=names) as refused:
        drive(**fields) if "sensors" not in fields else main_refuses(fields)
    assert "\n" not in str(refused.value)


def main_refuses(fields: dict) -> None:
    """Sensors are checked where a session begins."""
    Session(Scenario(**fields), None, [])


def test_the_sets_are_ten_and_fifty_and_a_scenario_is_saved_and_found_again() -> None:
    assert (len(SET_A), len(CASES), len({case.name for case in CASES})) == (10, 50, 50)
    assert CASES[:10] == SET_A
    assert {CALM, BRISK} <= {case.group for case in CASES[10:]}
    first = CASES[0].scenario(5, 0)
    assert Scenario.from_notes(first.as_notes()) == first
    assert CASES[0].scenario(5, 1) != first
    assert len({case.scenario(5, 0).car_seed for case in CASES}) == 1  # one car a repetition

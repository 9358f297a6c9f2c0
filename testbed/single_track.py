"""The single-track closed form of the car's steady cornering (linear range, small angles, flat road).

With D = side-slip angle of an axle, toe changes included, per lateral acceleration [rad s^2/m]:

    steering angle at the road wheels   delta = L k + (D_front - D_rear) v^2 k        k: path curvature
    slip angle of the body over the rear axle     beta = -D_rear v^2 k               at a point b ahead of it: + b k

    D = m_axle / C                        tyre: C = cornering stiffness of both tyres at the static load; m_axle by the
                                          lever law, with side forces that act the pneumatic trail t behind the axles
      + m_axle t / (2 c_steer)            the aligning moment turns the wheel on its bushes
      - toe_gain z                        travel z of the outer wheel per lateral acceleration
      + (roll + camber_gain z) K_camber / C   camber thrust of wheels that lean outward
    roll  = m_s h / (sum K_suspension - m_s g h), h above the roll axis; plus the same body on the tyres' springs

and, to first order in frequency, how far the path's curvature at the centre of gravity lags the steering, a distance:

    lag = yaw_lag v^2 / (1 + K_us v^2 / L) - b,   yaw_lag = [Jz (D_f/b + D_r/a)/m + a D_r + b D_f] / L

Left out: load transfer's effect on C (second order), the tyre's residual moment.
Source: Milliken, Race Car Vehicle Dynamics (1995), ch. 5; Pacejka, Tire and Vehicle Dynamics, 3rd ed., ch. 1.
"""

from __future__ import annotations

from dataclasses import dataclass

from models.tyre_properties import TyreProperties
from models.vehicle import GRAVITY, Axle, Payload, Vehicle
from testbed.tyre.magic_formula import slip_stiffness


@dataclass(frozen=True)
class SingleTrack:
    """mass [kg], yaw inertia [kg m^2] and the distances of the centre to the axles [m]; gradients D and body roll per
    lateral acceleration [rad s^2/m]; roll stiffness of suspension and of tyres by axle, front then rear [N m/rad]."""

    mass: float
    yaw_inertia: float
    to_front: float
    to_rear: float
    front_gradient: float
    rear_gradient: float
    roll_gradient: float
    suspension_roll: tuple[float, float]
    tyre_roll: tuple[float, float]

    @property
    def wheelbase(self) -> float:
        return self.to_front + self.to_rear

    @property
    def understeer(self) -> float:
        """K_us [rad s^2/m]."""
        return self.front_gradient - self.rear_gradient

    @property
    def yaw_lag(self) -> float:
        """Lag of the path behind the steering at low speed, without -b, over the speed's square [s^2/m]."""
        a, b, front, rear = self.to_front, self.to_rear, self.front_gradient, self.rear_gradient
        return (self.yaw_inertia / self.mass * (front / b + rear / a) + a * rear + b * front) / self.wheelbase

    def steering_angle(self, speed: float, curvature: float) -> float:
        """Mean road-wheel angle [rad] at a speed [m/s] on a curvature [1/m]."""
        return (self.wheelbase + self.understeer * speed**2) * curvature

    def rear_slip_angle(self, speed: float, curvature: float) -> float:
        """Angle from the body's x axis to the velocity over the rear axle [rad], positive to the left."""
        return -self.rear_gradient * speed**2 * curvature


def centre_of_gravity(vehicle: Vehicle, payload: Payload) -> tuple[float, float]:
    """Mass of the whole car [kg] and how far its centre lies ahead of the chassis' own [m]."""
    chassis, front, rear = vehicle.chassis, vehicle.front, vehicle.rear
    mass = vehicle.mass + payload.mass
    moment = 2.0 * front.wheel_assembly_mass * chassis.cg_to_front_axle
    moment -= 2.0 * rear.wheel_assembly_mass * chassis.cg_to_rear_axle
    return mass, (moment + payload.mass * payload.position[0]) / mass


def yaw_inertia(vehicle: Vehicle, payload: Payload) -> float:
    """Of the whole car about its centre of gravity [kg m^2]; wheels and payload as points."""
    mass, ahead = centre_of_gravity(vehicle, payload)
    chassis = vehicle.chassis
    inertia = chassis.yaw_inertia + payload.mass * payload.position[0] ** 2 - mass * ahead**2
    for axle, arm in ((vehicle.front, chassis.cg_to_front_axle), (vehicle.rear, chassis.cg_to_rear_axle)):
        inertia += 2.0 * axle.wheel_assembly_mass * (arm**2 + 0.25 * axle.track**2)
    return inertia


def single_track(vehicle: Vehicle, tyre: TyreProperties, payload: Payload) -> SingleTrack:
    """The closed form of a car on four equal tyres at their nominal pressure."""
    mass, ahead = centre_of_gravity(vehicle, payload)
    to_front, to_rear = vehicle.chassis.cg_to_front_axle - ahead, vehicle.chassis.cg_to_rear_axle + ahead
    length = to_front + to_rear
    axles, shares = (vehicle.front, vehicle.rear), (to_rear / length, to_front / length)
    loads = [0.5 * share * mass * GRAVITY for share in shares]
    trails = [_trail(tyre, load) for load in loads]
    reach = length + trails[1] - trails[0]
    carried = mass * (to_rear + trails[1]) / reach, mass * (to_front - trails[0]) / reach
    suspension = tuple((0.5 * a.spring_rate + a.anti_roll_rate) * a.track**2 for a in axles)
    tyres = tuple(0.5 * tyre.cz0 * a.track**2 for a in axles)
    axis = sum(share * 0.5 * a.track * a.axis_lateral for share, a in zip(shares, axles, strict=True))
    sprung = vehicle.chassis.mass + payload.mass
    arm = vehicle.chassis.cg_height + payload.mass * payload.position[2] / sprung - axis
    on_suspension = sprung * arm / (sum(suspension) - sprung * GRAVITY * arm)
    roll = on_suspension + mass * vehicle.chassis.cg_height / sum(tyres)
    front, rear = (
        _gradient(axle, tyre, load, of, trail, on_suspension, roll)
        for axle, load, of, trail in zip(axles, loads, carried, trails, strict=True)
    )
    return SingleTrack(
        mass, yaw_inertia(vehicle, payload), to_front, to_rear, front, rear, roll,
        (suspension[0], suspension[1]), (tyres[0], tyres[1]),
    )  # fmt: skip


def _trail(tyre: TyreProperties, load: float) -> float:
    """Pneumatic trail at zero slip [m], Magic Formula 6.1 (4.E43)."""
    return load / tyre.fz0 * tyre.r0 * (tyre.qdz1 + tyre.qdz2 * (load / tyre.fz0 - 1.0))


def _gradient(
    axle: Axle, tyre: TyreProperties, load: float, carried: float, trail: float, roll_on_springs: float, roll: float
) -> float:
    """D of an axle. load: of a wheel [N]; carried: side force of both over lateral acceleration [kg]; trail [m]; roll
    gradients [rad s^2/m]."""
    stiffness = 2.0 * slip_stiffness(tyre.slip_array(), load, tyre.p0)[1]
    camber = -2.0 * load * (tyre.pky6 + tyre.pky7 * (load / tyre.fz0 - 1.0))
    travel = 0.5 * axle.track * roll_on_springs
    lean = roll + axle.camber_gain * travel
    bushes = 0.5 * carried * trail / axle.steer_stiffness
    return (carried + lean * camber) / stiffness + bushes - axle.toe_gain * travel

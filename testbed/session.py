"""One drive under way: physics, sensors, estimators and recording, a stretch of about a second at a time.

The order within a stretch is the car's own: the road moves the car, the sensors feel it, the estimators hear the
sensors (and nothing else), and everything goes into the recording.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from estimators.car import Car
from estimators.drive_log import WHEELS, Signal
from estimators.faults import Injector
from estimators.faults.truth import fault_events, sound_signals
from estimators.runner import FLUSH, Bank
from models.tyre_properties import TyreProperties
from models.vehicle import Vehicle
from testbed.drive_recording import DriveRecording
from testbed.notes import drive_notes, ring_teeth
from testbed.scenario import SENSOR_STEP, Scenario
from testbed.sensors import Motion, SensorSuite, sensor_settings
from testbed.sensors.defaults import EDGE_NAMES, SPEED_NAMES
from testbed.sensors.settings import SensorSettings
from testbed.simulation import Simulation, Stretch
from testbed.verdicts import Verdicts

ACTIVE_STEERING = ("motor_angle", "motor_demand", "pinion_angle")  # columns of the trace, fields of the motion


def motion_of(stretch: Stretch, step: float, active_steering: bool = False) -> Motion:
    """What the sensors feel in a stretch, of the active steering too if the car has it; its rows on the sensors' grid
    of 1 ms."""
    tick = np.rint(stretch["time"] / step).astype(np.int64)
    keep = slice(None) if step == SENSOR_STEP else np.flatnonzero(tick % round(SENSOR_STEP / step) == 0)
    return Motion(
        time=stretch["time"][keep],
        accel_cg=stretch["accel"][keep],
        gyro=stretch["gyro"][keep],
        body_accel_z=stretch["body_accel_z"][keep],
        hub_accel_z=stretch["hub_accel_z"][keep],
        rim_angle=stretch["rim_angle"][keep],
        rim_speed=stretch["rim_speed"][keep],
        steering_wheel_angle=stretch["steering_wheel"][keep],
        engine_torque=stretch["engine_torque"][keep],
        driveline_torque=stretch["driveline_torque"][keep],
        tyre_pressure=stretch["pressure"][keep],
        tyre_temperature=stretch["temperature"][keep],
        **({name: stretch[name][keep] for name in ACTIVE_STEERING} if active_steering else {}),
    )


@dataclass(frozen=True)
class Variant:
    """What a campaign changes that a scenario cannot say; None leaves it as the scenario has it.

    vehicle, tyre: what drives. car: what the estimators are told of it. calibrations: what they learnt of it before,
    by estimator, over what `models/` holds of the car. only_read: sensors that no estimator reads are left out, which
    changes nothing for those that are there.
    """

    vehicle: Vehicle | None = None
    tyre: TyreProperties | None = None
    car: Car | None = None
    calibrations: Mapping[str, Mapping[str, Any]] | None = None
    only_read: bool = False


PLAIN = Variant()


def needed(settings: Mapping[str, SensorSettings], reads: Collection[str]) -> dict[str, SensorSettings]:
    """The sensors of these signals, and the encoders that bus speeds are computed from."""
    edges = {EDGE_NAMES[wheel] for wheel in WHEELS if SPEED_NAMES[wheel] in reads}
    return {name: figures for name, figures in settings.items() if name in reads or name in edges}


class Session:
    """A drive from its scenario. As a context manager it finishes the recording, or leaves it aside when the drive
    fails."""

    def __init__(
        self, scenario: Scenario, recording: Path | None, estimators: Sequence[str] | None, variant: Variant = PLAIN
    ) -> None:
        """estimators: names, None for all. ValueError for anything in the scenario that is not valid."""
        settings = sensor_settings(scenario.sensors, scenario.active_steering)
        self.simulation = Simulation(scenario, variant.vehicle, variant.tyre)
        notes = drive_notes(self.simulation, variant.car, variant.calibrations)
        self.bank = Bank(estimators, Car.from_notes(notes), notes["calibrations"])
        if variant.only_read:
            settings = needed(settings, self.bank.reads)
        self._verdicts = Verdicts(self.bank)
        self._faults = Injector(scenario.faults, scenario.seed, ring_teeth(scenario))
        self._suite = SensorSuite(settings, scenario.seed, self.simulation, car_seed=scenario.car_seed)
        self._recording = DriveRecording(recording, self.simulation, notes) if recording else None

    def run(self) -> Iterator[tuple[Stretch, dict[str, Signal]]]:
        """The drive to its end: each stretch with what the estimators said in it (`est/...`, `alarm/...`)."""
        scenario = self.simulation.scenario
        step, told = scenario.step, -math.inf
        for stretch in self.simulation.stretches():
            motion = motion_of(stretch, step, scenario.active_steering)
            sound = self._suite.advance(motion)
            sensed = self._faults.update(sound, motion.end)
            end = float(stretch["time"][-1]) + step
            last = end > scenario.duration - 0.5 * step
            said = self.bank.update(sensed, end + (FLUSH if last else 0.0))
            if self._recording:
                faults = self._faults.faults
                truth = fault_events(faults, told, end) | sound_signals(faults, sound)
                told = end
                lanes = self._verdicts.update()
                self._recording.add({**sensed, **said, **truth, **lanes}, stretch, self._verdicts.accused(sensed))
            yield stretch, said

    def __enter__(self) -> Session:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        if self._recording:
            self._recording.abort() if error else self._recording.close()

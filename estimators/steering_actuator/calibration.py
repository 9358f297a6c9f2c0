"""What is known of a car's active steering beforehand, as in `models/suv_steering_servo.json`.

    servo error    delta_M - servo model of delta_Md (`servo_model`)
    pinion error   delta_M - what pinion and steering wheel say of it (`pinion`)

both [rad of motor]: an error of the motor's angle sensor is the same in both, a motor that does not do what is demanded
is in the first, an error of the pinion's or the steering wheel's sensor, or one inside the servo's loop, in the second.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from estimators.steering_actuator.pinion import Ratios, checked_ratios
from estimators.steering_actuator.servo_model import ServoModel, checked
from estimators.steering_actuator.watch import Watch


@dataclass(frozen=True)
class Calibration:
    """The model and the ratios, and watches of both errors; what concerns the pinion may be missing."""

    servo: ServoModel
    servo_watch: Watch
    ratios: Ratios | None = None
    pinion_watch: Watch | None = None

    def as_json(self) -> dict[str, Any]:
        """JSON values."""
        document: dict[str, Any] = {"servo": self.servo._asdict(), "servo_watch": self.servo_watch.as_json()}
        if self.ratios is not None and self.pinion_watch is not None:
            document["ratios"] = self.ratios._asdict()
            document["pinion_watch"] = self.pinion_watch.as_json()
        return document

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> Calibration:
        """ValueError in one line if it is malformed."""
        try:
            servo = checked(ServoModel(**{name: float(value) for name, value in document["servo"].items()}))
            watch = Watch.from_json(document["servo_watch"])
            if "ratios" not in document:
                return cls(servo, watch)
            ratios = checked_ratios(Ratios(**{name: float(value) for name, value in document["ratios"].items()}))
            return cls(servo, watch, ratios, Watch.from_json(document["pinion_watch"]))
        except (KeyError, TypeError, AttributeError) as error:
            raise ValueError(f"calibration of the steering actuator: {type(error).__name__} {error}") from None

"""The car's sensors: true motion in, what its bus would carry out. `SensorSuite` is the way in."""

from testbed.sensors.motion import Motion
from testbed.sensors.overrides import sensor_settings
from testbed.sensors.suite import SensorSuite

__all__ = ["Motion", "SensorSuite", "sensor_settings"]

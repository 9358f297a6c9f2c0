"""Drifts and thresholds of the two comparisons."""

HOURS = 10.0
YAW_DRIFT, YAW_THRESHOLD = 2.0, 20.0
FORCE_DRIFT, FORCE_THRESHOLD = 2.0, 20.0

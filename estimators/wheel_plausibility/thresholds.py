"""Drift and level of the evidence against a wheel, from a stated false-alarm rate."""

import numpy as np

FALSE_ALARMS_PER_HOUR = 0.01
DRIFT, LEVEL = 1.2, 1.0  # m/s, m
LIMITS = np.array([DRIFT, LEVEL])

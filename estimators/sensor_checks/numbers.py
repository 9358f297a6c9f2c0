"""Rates and thresholds: one false alarm in `HOURS` over all that is compared, in `ALONE` over what each says alone.

The comparisons' residuals are neither white nor Gaussian, so h comes from a record of sound drives through
`estimators.detectors.empirical_threshold`, each of the six judgements a false alarm in 6 `HOURS` (the four hubs share
one h), from 2.3 h in 62 drives of the mix of the study that judges, with seeds of its own (555): `python -m
testbed.study.fault_matrix.design`. DRIFT was chosen on the first 20 of them. Repetition and lost messages have exact or
bounded laws (see there); what they are allowed is a hundredth."""

import numpy as np

HOURS = 10.0
ALONE = 1000.0
JUDGEMENTS = 6
LIMITS = np.array([7.3, 148.0, 341.0])  # rigid body, hub, lateral
FASTEST = 1000.0  # messages a second of a sensor at the most

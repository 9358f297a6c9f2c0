"""What the slow-leak monitor takes for granted, each number with its reason. SI; a month is 30 days.

Tuned on four trailers of a public fleet record (the study `fleet-leaks` reports on the other four): wander, noise,
drift, clip, outlier bound, what is tolerated, threshold. The threshold is the larger of two for the same false-alarm
rate: the exact one for independent Gaussian innovations, 14.31, and 15.5, which the tuning trailers' sound tyres ask
for (`empirical_threshold`): their innovations, mean taken off, in blocks of a week in a random order, which keeps what
correlation and tails they have. Tests design it anew, both ways.
"""

from __future__ import annotations

from typing import NamedTuple

DAY = 86400.0  # s
MONTH = 30.0 * DAY
YEAR = 365.25  # days

BETWEEN_FALSE_ALARMS = 50.0 * YEAR  # watched days of one tyre that loses no more than is tolerated
BLOCK = 7  # days that are kept together where innovations are put in a random order


class Model(NamedTuple):
    """tolerated: loss beyond that of the vehicle's other tyres that is no leak [Pa/s]. Natural losses (about 10
    kPa/month) are common to all; those of the fleet's sound tyres differ by up to 1.2 kPa/month. tolerated_alone: of a
    tyre without others to compare with, the natural loss itself.

    wander: variance that the level gains in a day, over that of a day's noise: with it the innovations of sound tyres
    are white (lag 1 to 7 days within 0.1). wander_leaking: the same after an alarm, so that the level keeps up.
    noise_std: of a day's value before it is measured [Pa]; noise_days: for how many days' values that counts;
    least_noise_std: a step of 1 kPa rounded, and what a small sample makes of it [Pa].

    drift: of the CUSUM [std], half the change of the whitened innovation looked for: 10 kPa/month beyond what is
    tolerated at a usual noise of 2.5 kPa. clip: what it takes of one day [std]: four days at least to an alarm.
    threshold [std]: for BETWEEN_FALSE_ALARMS, see above.
    """

    tolerated: float = 2e3 / MONTH
    tolerated_alone: float = 10e3 / MONTH
    wander: float = 0.02
    wander_leaking: float = 0.5
    noise_std: float = 3e3
    noise_days: float = 10.0
    least_noise_std: float = 1e3
    drift: float = 0.25
    clip: float = 4.0
    threshold: float = 15.5


MODEL = Model()
WARM_UP = 10  # days' values of a tyre before any alarm
MEMORY = 60  # days' values from which the noise is measured
MOST = 1.5  # thresholds that the CUSUM goes up to: a leak that is over is told so within some weeks
OUTLIER, LEAST_OUTLIER = 5.0, 5e3  # std and Pa of an innovation that is an outlier or a step, not a leak
OTHERS = 2  # tyres of the vehicle that must be known on a day to compare with

LOWEST, HIGHEST = 50e3, 1.5e6  # Pa, gauge: beyond it is no commercial vehicle's tyre
STALE = 6.0 * 3600.0  # s for which a repeated value is news
LEAST_SAMPLES = 3  # of a tyre in a day that make a day's value

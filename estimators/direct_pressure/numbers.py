"""What the monitor takes for granted, each number with its reason. SI.

The pressure that is followed is the amount of gas at the reference temperature, a = (p + atmosphere) T0 / T, [Pa]: the
ideal gas law takes the temperature out, a sound tyre has a constant a.
"""

from __future__ import annotations

from typing import NamedTuple

ATMOSPHERE = 101325.0  # Pa
REFERENCE = 293.15  # K
TOLERANCE = 2300.0  # Pa, std of a sensor's constant error: a third of the usual +-7 kPa
LOWEST_PRESSURE, HIGHEST_PRESSURE = -20e3, 1.5e6  # Pa, gauge; beyond it is no tyre's pressure
LOWEST_TEMPERATURE, HIGHEST_TEMPERATURE = 200.0, 480.0  # K
# K, K/s: gas warms by some 30 K in 15 min, of which a step of quantisation and noise is no part; beyond it is a fault
TEMPERATURE_STEP, TEMPERATURE_RATE = 5.0, 0.1
FASTEST_WHEEL = 500.0  # rad/s

BETWEEN_FALSE_ALARMS = 100.0 * 3600.0  # s, mean, over the four wheels together
SHIFTS = (0.04, 0.08, 0.16, 0.32, 0.64, 1.28, 2.56)  # changes of the whitened innovation looked for [std]
"""A leak's ramp moves the innovation's mean steadily; a CUSUM for half of what it is at the alarm is the quickest. From
10 kPa/h in 0.5 psi of noise at 20 Hz (0.06) to a burst; a factor of 2 apart costs at most 6 % of the delay."""


class Model(NamedTuple):
    """Noise of the quiet tyre and of the leak.

    disturbance_std, disturbance_time: of e, what the temperature signal and the ideal gas law leave over: half a step
    of 1 K is 0.6 kPa, the sensor's lag of half a minute while a tyre warms by 1 K/min 0.6 kPa, dynamic load 0.2 kPa.
    load_std, load_time: of l, while the car stands: a load dF deflects a tyre by df and takes F df / p of the gas'
    volume V (virtual work of an inflated membrane), (p + atmosphere) F df / (p V) of pressure; at 250 kPa and 49 litres
    (235/60R18) that is 0.35 to 0.42 kPa for 75 kg on a wheel, 1.1 to 1.25 kPa for 200 kg, 400 kg on the axle; it comes
    within seconds. wander: random walk of a [Pa/sqrt(s)]: slow drift of sensors. *_without_speed: such a change may
    come at any time; so large that one of 75 kg is within the designed rate at 1 Hz and slower. *_without_warmth:
    warming by 20 K is 24 kPa. rate_wander: random walk of the leak rate without an alarm [Pa/s/sqrt(s)]; *_after_alarm:
    after one, and relative_wander as a share of the rate [1/sqrt(s)]. load_std, wander and both of the rate's after an
    alarm were chosen on the days of the study `tpms-leak` with other seeds than the one it reports.
    """

    disturbance_std: float = 450.0
    disturbance_std_without_speed: float = 650.0
    load_std: float = 700.0
    load_time: float = 20.0
    disturbance_time: float = 40.0
    wander: float = 5.0
    wander_without_speed: float = 10.0
    disturbance_std_without_warmth: float = 8e3
    disturbance_time_without_warmth: float = 600.0
    rate_wander: float = 0.1
    rate_wander_after_alarm: float = 0.002
    relative_wander: float = 0.003
    noise_std: float = 640.0  # of a sample before it is measured: 500 Pa and a step of 1373 Pa
    least_noise_std: float = 200.0


MODEL = Model()
WARM_UP, WARM_UP_TIME = 18, 5.0  # samples and s from which the noise is measured before any alarm
PRIOR_WEIGHT = 5.0  # samples that `noise_std` counts for
LONGEST_WEIGHT = 4000.0  # samples that the measured noise goes back
OUTLIER = 8.0  # std of an innovation that the filter does not follow
CLIP = 6.0  # std that the CUSUM takes of it: at 1 Hz and faster one of them raises no alarm, two in a row do
BELIEVED = 3  # outliers in a row on one side that are a new pressure
STALE = 5.0  # typical intervals, and at least 120 s, after which the last temperature is worth nothing

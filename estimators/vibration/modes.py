"""The two rotational modes of a wheel on its tyre, and at which speed each can be heard in the wheel's speed.

    in phase    rim and belt turn together against the contact patch
    antiphase   rim against belt, through the sidewall's torsion

Frequencies, damping and sensitivities d ln f / d ln p (p: gauge pressure) are declared from the linearised car (see
the study `itpms-vibration`, which checks them), for want of a public source: 39.6 to 40.6 Hz front and 41.8 to 43.1 Hz
rear, damping ratio 0.09 at 20 km/h, 0.18 at 50, 0.27 at 80, 0.40 at 120, sensitivity 0.18 to 0.20 in phase; 86.1 and
88.5 Hz, 0.07 at every speed, 0.33 antiphase. The fore-aft mode of the hub at 14 Hz is the strongest of the spectrum,
but moves by 0.02 only; wheel hop (11 Hz) and the belt's fore-aft mode (119 Hz, below the timing noise) are not used,
and the antiphase mode is read up to 112 Hz only, where the latter's shoulder begins: up to 118 Hz it drew the
frequency up by 0.2 Hz at 80 km/h and above, and noise, which hides the shoulder, let it go again.

The contact patch does not feel a slope as short as itself: the road's input has a gap where f times the patch's length
(0.115 m) is the speed, at 95 Hz for 40 km/h. A mode is read where that gap is well above it: the antiphase one from 47
km/h on, the in-phase one from 32. Faster than 58 km/h slip has damped the in-phase mode so far that its peak is lost in
the slope of the hub's mode.

Towards its gap the patch tilts the spectrum, the more the slower the car: of a moving average over the length a the
power's slope is d ln sinc^2(a f / v) / d ln f, -6 at 50 km/h and -0.5 at 130 for the antiphase mode. A mode's slope is
therefore expected from the speed. With one slope for all speeds noise of the size of the signal, which leaves the slope
to its prior, drew the frequency by 0.05 Hz at 60 km/h.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

PATCH = 0.115  # m, length of the contact patch at nominal load and pressure
NEAREST_GAP = 0.85  # of the gap's frequency: nearer, the slope is that of this place; modes are read below it


@dataclass(frozen=True)
class Mode:
    """name; band of the spectrum that is fitted [Hz]; slowest, fastest: speeds at which it is read [m/s].

    frequency: prior of the natural frequency [Hz], frequency_std of its ln; damping: prior ratio, damping_std of its
    ln; slope, bend: prior (mean, std) of the road's shape, see `spectral_fit`, the slope besides the patch's.
    sensitivity: d ln f / d ln p, sensitivity_std its relative std between cars. road_std: of ln f from road class to
    class and speed to speed, which no averaging removes. speed_span: change of ln speed within which a spectrum is one.
    """

    name: str
    band: tuple[float, float]
    slowest: float
    fastest: float
    frequency: float
    frequency_std: float
    damping: float
    damping_std: float
    slope: tuple[float, float]
    bend: tuple[float, float]
    sensitivity: float
    sensitivity_std: float
    road_std: float
    speed_span: float

    @property
    def highest_needed(self) -> float:
        """Frequency up to which a spectrum must reach for the mode to be told in it [Hz]: beyond its peak."""
        return 1.2 * self.frequency

    def patch_slope(self, speed: float) -> float:
        """Slope d ln power / d ln f that the contact patch gives the road's input at a speed [m/s]."""
        x = math.pi * min(self.frequency * PATCH / max(speed, 1e-9), NEAREST_GAP)
        return 2.0 * (x / math.tan(x) - 1.0)


# slope and bend: mean and twice the spread of fits to drives on classes A to D at 48 to 130 km/h (seeds of their own)
ANTIPHASE = Mode(
    "antiphase", (58.0, 112.0), 13.0, math.inf, 87.0, 0.12, 0.075, 0.25, (1.0, 1.25), (3.0, 2.5), 0.33, 0.2, 0.005, 0.5
)
IN_PHASE = Mode(
    "in_phase", (24.0, 64.0), 9.0, 16.0, 41.0, 0.12, 0.15, 0.3, (-0.5, 4.0), (4.0, 5.0), 0.19, 0.2, 0.03, 0.15
)
MODES = (ANTIPHASE, IN_PHASE)

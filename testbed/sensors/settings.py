"""Settings of the sensors: what each kind has and which values are valid.

Amplitudes are in the signal's own SI unit. Figures named `..._std` are spreads between parts: one draw for each
channel when the suite is made. `delay` is from the instant of measurement to the time stamp, which is the moment the
value is on the bus. The defaults and their sources are in `defaults.py`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

from testbed.sensors.motion import STEPS_PER_SECOND

_MAX_PITCH_ERROR = 0.05  # of a pitch, rms: beyond it neighbouring edges of a drawn ring could swap
_LOG_GRID = 1e-9  # s, the drive log's resolution of time


@dataclass(frozen=True)
class AnalogueSettings:
    """A sensor whose value is sampled: y = clip(quantise((1 + scale error) x + bias + walk + noise)).

    rate [Hz], at most 1000. average: False: the value at the sampling instant (linear between two steps); True: the
    mean over the interval since the sample before (an anti-alias box filter, half an interval late). jitter: std of the
    sampling instants [s]; stamps follow the true instants. noise: std of one output sample, white. bias, bias_std:
    fixed and drawn. bias_walk: std of the bias after 1 s of random walk [unit/sqrt(s)]. scale, scale_std: relative
    error, fixed and drawn. quantisation: step, 0: none. low, high: saturation. delay [s]. dropout: probability that a
    sample is missing. burst: probability per sample that a gap of burst_length samples begins.
    """

    rate: float
    average: bool = False
    jitter: float = 0.0
    noise: float = 0.0
    bias: float = 0.0
    bias_std: float = 0.0
    bias_walk: float = 0.0
    scale: float = 0.0
    scale_std: float = 0.0
    quantisation: float = 0.0
    low: float = -math.inf
    high: float = math.inf
    delay: float = 0.0
    dropout: float = 0.0
    burst: float = 0.0
    burst_length: int = 1


@dataclass(frozen=True)
class EncoderSettings:
    """A toothed ring and its Hall sensor: one edge a tooth.

    teeth. jitter: std of the edge times [s], of the sensor's threshold in its noise (a constant 4 std of latency with
    it, so that no edge comes early). pitch_error: rms deviation of the ring's pitches from their mean, in pitches.
    timer: resolution of the edge times [s]. hysteresis: how far the ring turns back past an edge before the sensor
    switches back, in pitches. missing, double: probability per edge that it is lost, that a false one follows it after
    `double_gap` [s], rounded to whole ticks of the timer. delay [s].
    """

    teeth: int
    pitch_error: float
    timer: float
    hysteresis: float
    jitter: float = 0.0
    missing: float = 0.0
    double: float = 0.0
    double_gap: float = 1e-4
    delay: float = 0.0


@dataclass(frozen=True)
class BusSpeedSettings:
    """Wheel speed as the brake controller computes it from the edges.

    rate [Hz]. quantisation: step of the circumferential speed at the car's nominal radius [m/s]. timeout: after so long
    without an edge the wheel counts as standing [s]. delay [s], dropout, burst, burst_length as of any sensor.
    """

    rate: float
    quantisation: float
    timeout: float
    delay: float = 0.0
    dropout: float = 0.0
    burst: float = 0.0
    burst_length: int = 1


SensorSettings = AnalogueSettings | EncoderSettings | BusSpeedSettings

_MOST = 1e9  # of an amplitude, in any unit: beyond it numbers overflow
# field -> (lowest, highest) valid value, both included; fields not named here only need to be finite
_LIMITS: dict[str, tuple[float, float]] = {
    "rate": (1e-3, STEPS_PER_SECOND), "jitter": (0.0, 1.0), "noise": (0.0, _MOST), "bias": (-_MOST, _MOST),
    "bias_std": (0.0, _MOST), "bias_walk": (0.0, _MOST), "scale": (-1.0, _MOST), "scale_std": (0.0, 1.0),
    "quantisation": (0.0, _MOST), "delay": (0.0, 60.0), "dropout": (0.0, 1.0), "burst": (0.0, 1.0),
    "burst_length": (1, 10**6), "teeth": (2, 1000), "pitch_error": (0.0, _MAX_PITCH_ERROR),
    "timer": (_LOG_GRID, 0.01), "hysteresis": (0.0, 0.5), "missing": (0.0, 1.0), "double": (0.0, 1.0),
    "double_gap": (_LOG_GRID, 1.0), "timeout": (0.01, 60.0),
}  # fmt: skip


def check_settings(name: str, settings: SensorSettings) -> None:
    """ValueError when a value is of the wrong type, not a number or out of its limits."""
    for part in fields(settings):
        _check(f"{name} {part.name}", part.name, getattr(settings, part.name), part.type)
    if isinstance(settings, AnalogueSettings) and not settings.low < settings.high:
        raise ValueError(f"{name}: low {settings.low} is not below high {settings.high}")


def _check(what: str, key: str, value: Any, kind: Any) -> None:
    if kind == "bool":
        if not isinstance(value, bool):
            raise ValueError(f"{what}: {value!r} is not True or False")
        return
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"{what}: {value!r} is not a number")
    if kind == "int" and value != int(value):
        raise ValueError(f"{what}: {value!r} is not a whole number")
    low, high = _LIMITS.get(key, (-math.inf, math.inf))
    unbounded = key in ("low", "high")
    if (math.isinf(value) and not unbounded) or not low <= value <= high:  # NaN is within no limits
        limits = (
            f"from {low:g} to {high:g}" if key in _LIMITS else "finite" if not unbounded else "a number or infinite"
        )
        raise ValueError(f"{what}: {value!r} is not valid, want {limits}")

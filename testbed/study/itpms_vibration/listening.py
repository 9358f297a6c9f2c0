"""A drive heard by every method: the tracked wheel speeds, the Whittle fit, and the published methods beside it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfilt

from estimators.drive_log import WHEELS
from estimators.vibration.modes import ANTIPHASE, Mode
from estimators.vibration.published.ar2 import kalman, least_squares, natural_frequency
from estimators.vibration.published.fft_batch import BATCH, peak_frequency
from estimators.vibration.wheel_vibration import Reading, WheelVibration
from estimators.wheel_speed.edge_speed import TEETH, EdgeSpeed, Samples
from estimators.wheel_speed.resampling import RATE
from testbed.scenario import Scenario
from testbed.sensors import SensorSuite, sensor_settings
from testbed.session import motion_of
from testbed.simulation import Simulation

METHODS = ("vibration", "fft", "ar2_rls", "ar2_kalman")
JUDGED = 60.0  # s of record that a method's word rests on
LEAD = 4.0  # s before it: start-up of the filters
INNOVATION = 0.1  # variance of the AR(2) input over that of the band-passed signal, declared


@dataclass(frozen=True)
class Heard:
    """Of one wheel: samples by second, and turns by which the ring was known then; true rim speed [rad/s] at 1 kHz."""

    wheel: str
    samples: Sequence[Samples]
    learnt: Sequence[float]
    rim_speed: NDArray[np.float64]

    @property
    def speed(self) -> NDArray[np.float64]:
        """The last JUDGED seconds of tracked speed [rad/s] at RATE, gaps filled in."""
        every = np.concatenate([s.speed for s in self.samples])[-round(JUDGED * RATE) :]
        known = np.isfinite(every)
        return np.interp(np.arange(len(every)), np.flatnonzero(known), every[known])


def drive(scenario: Scenario) -> list[Heard]:
    """The four wheels of a drive through its sensors."""
    simulation = Simulation(scenario)
    suite = SensorSuite(sensor_settings(scenario.sensors), scenario.seed, simulation, car_seed=scenario.car_seed)
    trackers = [EdgeSpeed() for _ in WHEELS]
    samples: list[list[Samples]] = [[] for _ in WHEELS]
    learnt: list[list[float]] = [[] for _ in WHEELS]
    rims = []
    for stretch in simulation.stretches():
        sensed = suite.advance(motion_of(stretch, scenario.step))
        rims.append(stretch["rim_speed"])
        end = round(float(stretch["time"][-1]) + scenario.step)
        for w, wheel in enumerate(WHEELS):
            trackers[w].add(sensed[f"wheel/{wheel}/edges"].time)
            samples[w].append(trackers[w].advance(float(end))[0])
            learnt[w].append(float(trackers[w].ring.turns.min()))
    rim = np.concatenate(rims)
    return [Heard(wheel, samples[w], learnt[w], rim[:, w]) for w, wheel in enumerate(WHEELS)]


def readings(heard: Heard, radius: float, noise: NDArray[np.float64] | None = None) -> list[Reading]:
    """All readings of the Whittle fit; noise: added to the samples [rad/s], from their end backwards."""
    analysis, said, at = WheelVibration(heard.wheel, radius), [], 0
    total = sum(len(s.speed) for s in heard.samples)
    added = np.zeros(total)
    if noise is not None:
        added[-len(noise) :] = noise[-total:]
    for number, (samples, learnt) in enumerate(zip(heard.samples, heard.learnt, strict=True)):
        n = len(samples.speed)
        noisy = Samples(samples.first, samples.speed + added[at : at + n], samples.knots)
        said += analysis.advance(noisy, number + 1.0, learnt)
        at += n
    return said


def band_passed(speed: NDArray[np.float64], mode: Mode) -> NDArray[np.float64]:
    """What AR(2) is fed: a causal fourth-order Butterworth band-pass over the mode's band."""
    sections = butter(4, mode.band, btype="bandpass", fs=RATE, output="sos")
    return sosfilt(sections, speed - speed[:400].mean())[round(RATE) :]


def published(speed: NDArray[np.float64], mode: Mode, filtered: bool = True) -> dict[str, float]:
    """Frequencies [Hz] by the published methods from JUDGED seconds: mean of the batches, last word of the filters."""
    batch = round(BATCH * RATE)
    peaks = [peak_frequency(speed[i : i + batch], RATE, mode.band) for i in range(0, len(speed) - batch + 1, batch)]
    signal = band_passed(speed, mode) if filtered else speed - speed.mean()
    return {
        "fft": float(np.mean(peaks)) if peaks else math.nan,
        "ar2_rls": _natural(least_squares(signal, RATE)),
        "ar2_kalman": _natural(kalman(signal, RATE, INNOVATION)),
    }


def _natural(course: NDArray[np.float64]) -> float:
    """Of the last a1, a2 [Hz]."""
    a1, a2 = course[-1]
    return natural_frequency(float(a1), float(a2), RATE)


def last_running(said: Sequence[Reading], mode: Mode = ANTIPHASE) -> Reading:
    """What the fit says of a mode at the end."""
    return [r for r in said if r.kind == "running" and r.mode is mode][-1]


def words(heard: Heard, radius: float, mode: Mode, noise: NDArray[np.float64] | None = None) -> dict[str, Any]:
    """By method, the frequency [Hz] at the end of the drive; and what the fit says besides."""
    last = last_running(readings(heard, radius, noise), mode)
    speed = heard.speed if noise is None else heard.speed + noise[-len(heard.speed) :]
    return {
        "vibration": last.frequency,
        **published(speed, mode),
        "std": last.frequency * last.ln_std,
        "excitation": last.excitation,
        "parameters": list(last.parameters),
    }


def wheel_speed_noise(heard: Heard, mode: Mode, share: float, seed: int) -> NDArray[np.float64]:
    """White noise [rad/s] at RATE, `share` of the r.m.s. of the wheel speed within the mode's band."""
    band = band_passed(heard.speed, mode)
    return share * float(np.std(band)) * np.random.default_rng(seed).standard_normal(len(heard.speed))


TIMING = 2.0 * (2.0 * np.pi) ** 2 * (2.0 * np.pi / TEETH) / 12.0


def timer_noise(omega: float, f: float, timer: float) -> float:
    """PSD [(rad/s)^2/Hz] at f [Hz] of rounding edge times to `timer` [s] at wheel speed omega [rad/s]: edge times have
    variance timer^2 / 12 and come at TEETH omega / 2 pi a second, the angle they tell is omega times as wrong."""
    return TIMING * omega * timer**2 * f**2

"""The study's tasks: drives of one condition each, and a process of known frequency. What a task gives is JSON values.

cell: a road class at a constant speed, for scatter against the bound. pressure: the same road at 100, 85, 70 % in all
tyres, for the sensitivity, Figures 2 and 3, and (at 100 %) for noise added to the tracked wheel speed. run: one of the
paper's 30 (Figure 4). known: a Gaussian process whose natural frequency is known, through the same analysis.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.drive_log import WHEELS
from estimators.vibration.modes import ANTIPHASE, MODES, Mode
from estimators.vibration.published.ar2 import kalman, least_squares, natural_frequency
from estimators.vibration.published.fft_batch import smoothed_spectrum
from estimators.vibration.wheel_vibration import WheelVibration
from estimators.wheel_speed.edge_speed import TEETH, Samples
from estimators.wheel_speed.resampling import RATE, droop
from testbed.scenario import Scenario
from testbed.study.itpms_vibration.listening import (
    INNOVATION,
    JUDGED,
    LEAD,
    METHODS,
    Heard,
    band_passed,
    drive,
    last_running,
    published,
    readings,
    wheel_speed_noise,
    words,
)  # fmt: skip
from testbed.study.study import run_seed

RADIUS = 0.36  # m, nominal: turns a mode's speeds into wheel speeds
NOMINAL = 250e3  # Pa
RATIOS = (1.0, 0.85, 0.7)
SHARES = (0.0, 0.3, 1.0)  # of added noise
CELLS = (
    *((road, v, "antiphase") for road in "ABC" for v in (60.0, 90.0, 130.0)),
    *(("D", v, "antiphase") for v in (60.0, 90.0)),
    *((road, 45.0, "in_phase") for road in "ABCD"),
)  # class, km/h, mode that is heard there
PRESSURE_CELLS = (("C", 80.0, "antiphase"), ("C", 45.0, "in_phase"))
RUNS = (
    ("A", 80.0, "constant"), ("B", 60.0, "constant"), ("C", 90.0, "motorway"), ("D", 60.0, "constant"),
    ("B", 110.0, "motorway"), ("C", 60.0, "town"), ("A", 120.0, "constant"), ("C", 70.0, "slalom"),
    ("A:300,C:400,B:4000", 80.0, "constant"), ("A", 100.0, "motorway"),
)  # fmt: skip
# frequency [Hz], damping ratio, then speeds [km/h] with slope and bend of the road's input as fits to the car have them
KNOWN = {
    "antiphase": (84.0, 0.07, ((60.0, -2.5, 1.0), (80.0, -0.6, 3.5), (130.0, 1.0, 1.0))),
    "in_phase": (40.0, 0.15, ((45.0, 0.0, 6.0),)),
}
RECORDS, PUBLISHED_RECORDS = 32, 8  # of each shape in a repetition; of which the published methods hear some
UNHEARD = dict.fromkeys(METHODS[1:], float("nan"))
PAIRS = 2  # of noises added to a wheel's record
SMALL = 14.0  # s of a drive in the small form


def mode_of(name: str) -> Mode:
    """By name."""
    return next(mode for mode in MODES if mode.name == name)


def tasks(seed: int, number: int, small: bool) -> list[dict[str, Any]]:
    """Of repetition `number`."""
    duration = SMALL if small else JUDGED + LEAD

    def one(kind: str, purpose: int, **more: Any) -> dict[str, Any]:
        return {"kind": kind, "number": number, "seed": run_seed(seed, number, purpose), "duration": duration, **more}

    cells = CELLS[:1] if small else CELLS
    return [
        *(one("cell", 1 + i, road=road, speed=v, mode=mode) for i, (road, v, mode) in enumerate(cells)),
        *(one("pressure", 50, road=road, speed=v, mode=mode, ratio=ratio)
          for road, v, mode in PRESSURE_CELLS[: 1 if small else None] for ratio in RATIOS),
        *(one("run", 60 + i, ratio=ratio) for i, ratio in enumerate(RATIOS)),
        *(one("known", 70, mode=mode) for mode in KNOWN),
    ]  # fmt: skip


def work(task: dict[str, Any]) -> dict[str, Any]:
    """The row of a task."""
    return {"task": task} | {"cell": _cell, "pressure": _pressure, "run": _run, "known": _known}[task["kind"]](task)


def _drive(task: dict[str, Any], road: str, speed: float, manoeuvre: str = "constant") -> list[Heard]:
    pressures = dict.fromkeys(WHEELS, task.get("ratio", 1.0) * NOMINAL)
    return drive(
        Scenario(
            road=road, speed=speed / 3.6, manoeuvre=manoeuvre, duration=task["duration"], seed=task["seed"],
            pressures=pressures,
        )
    )  # fmt: skip


def _cell(task: dict[str, Any]) -> dict[str, Any]:
    mode, heard = mode_of(task["mode"]), _drive(task, task["road"], task["speed"])
    row: dict[str, Any] = {"omega": [float(np.mean(h.rim_speed)) for h in heard]}
    row["words"] = [words(h, RADIUS, mode) for h in heard]
    row["level"] = [_level(h.rim_speed, mode.frequency) for h in heard]
    return row


def _level(rim_speed: NDArray[np.float64], f: float) -> float:
    """True PSD of the wheel speed within 5 % of f [(rad/s)^2/Hz]."""
    lines, power = smoothed_spectrum(rim_speed, 1000.0)
    return float(power[np.abs(lines / f - 1.0) < 0.05].mean())


def _pressure(task: dict[str, Any]) -> dict[str, Any]:
    mode, heard = mode_of(task["mode"]), _drive(task, task["road"], task["speed"])
    shares = SHARES if task["ratio"] == 1.0 else SHARES[:1]
    row: dict[str, Any] = {"words": [[words(h, RADIUS, mode) for h in heard]]}
    for share in shares[1:]:
        row["words"].append([_noisy(h, mode, share, task["seed"] + 1000 * w) for w, h in enumerate(heard)])
    if task["number"] == 0:
        row |= _example(heard[0], mode)
    return row


def _noisy(heard: Heard, mode: Mode, share: float, seed: int) -> dict[str, float]:
    """By method, the mean frequency [Hz] of PAIRS noises, each added and taken off: what noise and drive have in common
    cancels to first order, and what is left is the bias."""
    noises = [wheel_speed_noise(heard, mode, share, seed + k) for k in range(PAIRS)]
    every = [words(heard, RADIUS, mode, sign * noise) for noise in noises for sign in (1.0, -1.0)]
    return {method: float(np.mean([said[method] for said in every])) for method in METHODS}


def _example(heard: Heard, mode: Mode) -> dict[str, Any]:
    """For Figures 2 and 3: the front left wheel's last batch, and what each recursion says over time."""
    f, power = smoothed_spectrum(heard.speed[-round(30.0 * RATE) :], RATE)
    kept = slice(None, np.searchsorted(f, 130.0), 10)
    running = [r for r in readings(heard, RADIUS) if r.kind == "running" and r.mode is mode]
    signal = band_passed(heard.speed, mode)
    every = slice(round(RATE) - 1, None, round(RATE))
    courses = {"ar2_rls": least_squares(signal, RATE)[every], "ar2_kalman": kalman(signal, RATE, INNOVATION)[every]}
    return {
        "f": f[kept].tolist(),
        "power": power[kept].tolist(),
        "course": {
            "vibration": [[r.time, r.frequency, r.frequency * r.ln_std] for r in running],
            **{
                name: [[LEAD + 2.0 + i, natural_frequency(float(a1), float(a2), RATE)] for i, (a1, a2) in enumerate(c)]
                for name, c in courses.items()
            },
        },
    }


def _run(task: dict[str, Any]) -> dict[str, Any]:
    """Means over the run of ln frequency from blocks alone, by wheel; null where nothing was heard."""
    means: list[list[float] | None] = []
    for heard in _drive(task, *RUNS[task["number"] % len(RUNS)]):
        blocks = [r for r in readings(heard, RADIUS) if r.kind == "block" and r.mode is ANTIPHASE]
        weight = np.array([r.information for r in blocks])
        value = np.log([r.frequency for r in blocks])
        means.append([float(weight @ value / weight.sum()), float(weight.sum() ** -0.5)] if len(blocks) else None)
    return {"means": means}


def known_process(
    mode: str, shape: tuple[float, float, float], seconds: float, seed: int, frequency: float | None = None
) -> NDArray[np.float64]:
    """RATE samples of wheel speed between teeth less its mean, Gaussian, r.m.s. 0.01 rad/s: one mode of `frequency`
    [Hz] (None: KNOWN's), its input shaped as `spectral_fit` says within the mode's band and nothing outside."""
    known, damping, _ = KNOWN[mode]
    kmh, slope, bend = shape
    n = round(seconds * RATE)
    f = np.fft.rfftfreq(n, 1.0 / RATE)
    x, u = f / (frequency or known), np.log(np.maximum(f, 1.0) / mode_of(mode).frequency)
    low, high = mode_of(mode).band
    inside = (f > low - 4.0) & (f < high + 4.0)
    felt = np.exp(0.5 * u * (slope + u * bend)) * droop(f, TEETH * kmh / 3.6 / (2.0 * np.pi * RADIUS))
    gain = np.where(inside, felt / np.sqrt((1.0 - x**2) ** 2 + (2.0 * damping * x) ** 2), 0.0)
    rng = np.random.default_rng(seed)
    signal = np.fft.irfft(gain * (rng.standard_normal(len(f)) + 1j * rng.standard_normal(len(f))), n)
    return 0.01 * signal / np.std(signal)


def _known(task: dict[str, Any]) -> dict[str, Any]:
    """By shape, share of noise and record, what each method says."""
    mode = mode_of(task["mode"])
    words: list[list[list[dict[str, float]]]] = []
    for k, shape in enumerate(KNOWN[task["mode"]][2]):
        words.append([[] for _ in SHARES])
        for w in range(1 if task["duration"] == SMALL else RECORDS):
            signal = known_process(task["mode"], shape, min(JUDGED, task["duration"]), task["seed"] + 100 * k + w)
            noise = np.random.default_rng((task["seed"], k, w)).standard_normal(len(signal))
            for said, share in zip(words[k], SHARES, strict=True):
                speed = shape[0] / 3.6 / RADIUS + signal + share * np.std(signal) * noise
                others = published(speed, mode, filtered=False) if w < PUBLISHED_RECORDS else UNHEARD
                said.append({"vibration": last_word(speed, mode), **others})
    return {"words": words}


def last_word(speed: NDArray[np.float64], mode: Mode) -> float:
    """Frequency [Hz] that the fit says at the end of a made-up wheel's samples, heard in one stretch: up to JUDGED
    seconds the memory does not fade, so it comes to the same as second by second."""
    samples = Samples(0, speed, float(TEETH))
    return last_running(
        WheelVibration("fl", RADIUS, (mode,)).advance(samples, len(speed) / RATE, np.inf), mode
    ).frequency


def made_up_wheel(speed: NDArray[np.float64]) -> Heard:
    """Samples of a made-up wheel, second by second."""
    size = round(RATE)
    seconds = range(len(speed) // size)
    samples = [Samples(size * i, speed[size * i : size * (i + 1)], float(TEETH)) for i in seconds]
    return Heard("fl", samples, [np.inf] * len(samples), speed)

"""The thesis' trial and error as a rule: never an alarm on sound drives, and then as soon as can be.

For each residual and each drift (or forgetting factor) of a grid the threshold is MARGIN times the largest statistic on
the sound tuning drives, never below the drift; of these the one is taken that finds the errors of `faulty` soonest on
the average, one that is not found counting as the drive's length. Limits of local ones: the largest residual, half of
it, and so on. Only tuning drives come here; what the detectors then do is told on others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.detectors import Monitor
from estimators.steering_actuator.published import Method, detector
from estimators.steering_actuator.residuals import RESIDUALS, STEP

MARGIN = 1.1  # declared: the thesis speaks of margins and gives none
LOCAL_CHANNELS = 6
DRIFTS = tuple(np.geomspace(1e-3, 0.7, 16).tolist())  # of the largest residual that a channel sees
FORGETTING = (0.9, 0.95, 0.97, 0.98, 0.985, 0.99, 0.995, 0.998)
FAST_FORGETTING = (0.9,)

Array = NDArray[np.float64]
Numbers = dict[str, Any]


def tuned(method: Method, sound: Sequence[Array], faulty: Sequence[Array]) -> dict[str, Numbers]:
    """Numbers of each of RESIDUALS. sound, faulty: residuals of drives, each (n, 3), [deg] and its derivatives."""
    shown, wrong = [method.seen(eps) for eps in sound], [method.seen(eps) for eps in faulty]
    return {
        name: _of_residual(method, [eps[:, i] for eps in shown], [eps[:, i] for eps in wrong])
        for i, name in enumerate(RESIDUALS)
    }


def _of_residual(method: Method, sound: list[Array], faulty: list[Array]) -> Numbers:
    largest = max(float(np.nanmax(np.abs(x))) for x in sound)
    if method.family not in ("local", "local_global"):
        return _best(method, sound, faulty, _choices(method, largest))
    limits: list[float | None] = [largest * 0.5**k for k in range(LOCAL_CHANNELS - 1, -1, -1)]
    if method.family == "local_global":
        limits.append(None)
    channels = [_best(method, sound, faulty, _local_choices(limit, largest)) for limit in limits]
    return {key: [channel[key][0] for channel in channels] for key in ("limits", "drifts", "thresholds")}


def _choices(method: Method, largest: float) -> Iterable[Numbers]:
    if method.family == "cusum":
        return [{"drift": share * largest, "threshold": 1.0} for share in DRIFTS]
    if method.family in ("average", "forgetful"):
        factors = FORGETTING if method.family == "average" else FAST_FORGETTING
        return [{"forgetting": factor, "threshold": 1.0} for factor in factors]
    return [{"threshold": 1.0}]


def _local_choices(limit: float | None, largest: float) -> Iterable[Numbers]:
    reach = largest if limit is None else limit
    return [{"limits": [limit], "drifts": [share * reach], "thresholds": [1.0]} for share in DRIFTS]


def _best(method: Method, sound: list[Array], faulty: list[Array], choices: Iterable[Numbers]) -> Numbers:
    """With its threshold set."""
    found: tuple[float, Numbers] | None = None
    for numbers in choices:
        least = max(numbers.get("drift", 0.0), *numbers.get("drifts", [0.0]), 1e-9)
        statistic = _statistic(method, numbers)
        level = max(MARGIN * max(float(statistic(x).max()) for x in sound), least)
        delay = float(np.mean([_delay(statistic(x), level) for x in faulty]))
        if found is None or delay < found[0]:
            found = delay, _with_threshold(numbers, level)
    assert found is not None
    return found[1]


def _statistic(method: Method, numbers: Numbers) -> Callable[[Array], Array]:
    of = detector(method, numbers)
    return lambda x: Monitor(of).run(x).statistic


def _delay(statistic: Array, level: float) -> float:
    over = statistic > level
    return STEP * (int(np.argmax(over)) + 1 if over.any() else len(statistic))


def _with_threshold(numbers: Numbers, level: float) -> Numbers:
    return {**numbers, "thresholds": [level]} if "thresholds" in numbers else {**numbers, "threshold": level}

"""How far estimates are from the truth, by method and quantity, the four wheels of a quantity together and each alone.

The wheels of a drive count as more samples of that drive, not as more drives.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.scores.accuracy import bias, error_over_time, rmse, settling_times, std
from estimators.scores.consistency import nees_consistency, nees_of_std, share_within
from estimators.scores.interval import Band, proportion_interval
from estimators.scores.survival import event_curve
from testbed.campaign.judge_columns import QUANTITIES, Drives, Name, Quantity

Figures = dict[str, Any]


def judge_estimates(drives: Drives) -> list[Figures]:
    """An entry for each method and quantity: its figures, `over_time` and `wheels` (the same for each wheel)."""
    entries = []
    for (method, kind), group in groupby(drives.names(), key=lambda n: (n.method, n.quantity)):
        names, quantity = list(group), QUANTITIES[kind]
        figures = _figures(drives, names, quantity)
        if figures is None:
            continue
        wheels = {n.wheel: _figures(drives, [n], quantity) for n in names if n.wheel}
        identity = {"method": method, "quantity": kind, "label": quantity.label, "unit": quantity.unit}
        entries.append(identity | {"settled_below": quantity.settled} | figures | {"wheels": wheels})
    return entries


def errors(drives: Drives, names: list[Name]) -> NDArray[np.float64]:
    """Errors of some wheels side by side, in the unit shown, shape (drives, wheels * n)."""
    estimates = [drives.estimate(name) for name in names]
    return np.concatenate([value - truth for value, _, truth in estimates], axis=1)


def _figures(drives: Drives, names: list[Name], quantity: Quantity) -> Figures | None:
    """None where nothing was ever estimated."""
    error = errors(drives, names)
    seen = np.isfinite(error).any(axis=1)
    if not seen.any():
        return None
    spread = np.concatenate([drives.estimate(name)[1] for name in names], axis=1)
    return {
        "drives": int(seen.sum()),
        "rmse": rmse(error).json(),
        "bias": bias(error).json(),
        "std": std(error).json() if seen.sum() > 1 else None,
        **_settling(drives, error, len(names), quantity),
        **_consistency(error, spread),
        "over_time": _over_time(drives.time, error, len(names)),
    }


def _settling(drives: Drives, error: NDArray[np.float64], wheels: int, quantity: Quantity) -> Figures:
    """Time until the worst of the wheels is settled, and the share of drives that are at their end."""
    worst = _worst_of(error, wheels)
    events = settling_times(worst, drives.time, quantity.settled, drives.ends)
    return {
        "settling_s": event_curve(events).quantile(0.5).json(),
        "settled": proportion_interval(int(events.observed.sum()), len(events)).json(),
    }


def _consistency(error: NDArray[np.float64], spread: NDArray[np.float64]) -> Figures:
    """NEES, 1 if reported deviations are true, and the share of errors within one and two of them; null without any."""
    both = np.isfinite(error) & np.isfinite(spread)
    if not both.any():
        return {"nees": None, "within_1_std": None, "within_2_std": None}
    return {
        "nees": nees_consistency(nees_of_std(error, spread)).mean.json(),
        "within_1_std": share_within(error, spread, 1.0).json(),
        "within_2_std": share_within(error, spread, 2.0).json(),
    }


def _worst_of(error: NDArray[np.float64], wheels: int) -> NDArray[np.float64]:
    """The largest magnitude over the wheels at each time, shape (drives, n)."""
    cube = np.abs(error).reshape(len(error), wheels, -1)
    return np.where(np.isnan(cube).all(axis=1), np.nan, np.fmax.reduce(cube, axis=1))


def _over_time(time: NDArray[np.float64], error: NDArray[np.float64], wheels: int) -> Figures:
    """Bias and 5-95 % band over drives at each time; of one wheel only, since wheels are not more drives."""
    if wheels > 1:
        return {}
    found = error_over_time(error)
    columns: Mapping[str, Band] = {"bias": found.bias, "rmse": found.rmse, "q05": found.q05, "q95": found.q95}
    return {"time_s": time.tolist()} | {name: finite(band.value) for name, band in columns.items()} | {
        "bias_ci95": [finite(found.bias.low), finite(found.bias.high)]
    }  # fmt: skip


def finite(values: NDArray[np.float64]) -> list[float | None]:
    """JSON values; None for what is not finite."""
    return [float(v) if np.isfinite(v) else None for v in values]

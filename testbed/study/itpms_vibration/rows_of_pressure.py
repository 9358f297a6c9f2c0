"""Rows on what lost pressure does to the frequencies, and on the paper's 30 runs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from estimators.drive_log import WHEELS
from estimators.scores.interval import mean_interval, shared_proportion_interval
from estimators.vibration.modes import ANTIPHASE
from testbed.study.itpms_vibration.drives import PRESSURE_CELLS, RATIOS
from testbed.study.itpms_vibration.linearised import mode_at, sensitivity
from testbed.study.itpms_vibration.listening import METHODS
from testbed.study.study import Row, StudyRow


def indications(rows: Sequence[Row]) -> dict[float, tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """By ratio of pressure: ln of each run's mean frequency over the nominal runs' mean, and its std; shape (runs,
    wheels), nan where nothing was heard."""
    heard = {}
    for ratio in RATIOS:
        of = [row["means"] for row in rows if row["task"]["kind"] == "run" and row["task"]["ratio"] == ratio]
        heard[ratio] = np.array([[m or (np.nan, np.nan) for m in means] for means in of], float).reshape(
            -1, len(WHEELS), 2
        )
    nominal = heard[1.0][:, :, 0]
    known = np.isfinite(nominal)
    mean = np.where(known, nominal, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    return {ratio: (value[:, :, 0] - mean, value[:, :, 1]) for ratio, value in heard.items()}


def table(rows: Sequence[Row]) -> Iterator[StudyRow]:
    """See `itpms_vibration`."""
    yield from _sensitivities(rows)
    found = indications(rows)
    nominal = found[1.0][0]
    for ratio in RATIOS[1:]:
        low = found[ratio][0]
        if not len(low) or not len(nominal):
            continue
        threshold = 0.5 * ANTIPHASE.sensitivity * np.log(ratio)
        right = [(low < threshold).mean(axis=1), (nominal > threshold).mean(axis=1)]
        percent = round(100.0 * (1.0 - ratio))
        yield StudyRow.of(f"share_separated_{percent}_percent", "-", shared_proportion_interval(np.concatenate(right)))
    for _, speed, mode in PRESSURE_CELLS:
        for axle in ("front", "rear"):
            frequency, damping = mode_at(speed, 1.0)[axle][mode]
            yield StudyRow(f"linearised_{mode}_{axle}_{speed:g}_km_h", "Hz", None, None, None, frequency)
            yield StudyRow(f"linearised_damping_{mode}_{axle}_{speed:g}_km_h", "-", None, None, None, damping)


def _mean_change(low: Sequence[Row], full: Sequence[Row], method: str) -> float:
    """Of ln frequency, mean of the wheels."""
    return float(np.mean([np.log(at_low[method] / at_full[method]) for at_low, at_full in zip(low, full, strict=True)]))


def _sensitivities(rows: Sequence[Row]) -> Iterator[StudyRow]:
    for _, speed, mode in PRESSURE_CELLS:
        of = {
            (row["task"]["number"], row["task"]["ratio"]): row["words"][0]
            for row in rows
            if row["task"]["kind"] == "pressure" and row["task"]["mode"] == mode
        }
        whole = [n for n, ratio in of if ratio == 1.0 and (n, RATIOS[-1]) in of]
        for method in METHODS:
            change = [_mean_change(of[n, RATIOS[-1]], of[n, 1.0], method) for n in whole]
            change = [c for c in change if np.isfinite(c)]
            if change:
                here = mean_interval(np.array(change) / np.log(RATIOS[-1]))
                yield StudyRow.of(f"{method}_sensitivity_{mode}", "-", here, limit=sensitivity(mode, speed, RATIOS[-1]))

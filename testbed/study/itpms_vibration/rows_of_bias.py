"""Rows on what added white noise does to each method's frequency."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from estimators.scores.interval import Interval, mean_interval
from testbed.study.itpms_vibration.drives import KNOWN, PRESSURE_CELLS, SHARES
from testbed.study.itpms_vibration.linearised import mode_at
from testbed.study.itpms_vibration.listening import METHODS
from testbed.study.study import Row, StudyRow

MOST_BIAS = 0.1  # Hz


def _words(rows: Sequence[Row], kind: str, mode: str, method: str) -> NDArray[np.float64]:
    """Frequencies [Hz] by repetition, shape of the process (one for the car), share of noise, and wheel or record."""
    of = [row for row in rows if row["task"]["kind"] == kind and row["task"]["mode"] == mode]
    of = [row for row in of if row["task"].get("ratio", 1.0) == 1.0]
    words = [row["words"] if kind == "known" else [row["words"]] for row in of]
    return np.array([[[[w[method] for w in share] for share in shape] for shape in row] for row in words], float)


def biases(rows: Sequence[Row], mode: str, method: str) -> dict[str, Interval]:
    """By truth and share of noise [Hz], of the process the shape in which the bias is largest."""
    every = cells(rows, mode, method)
    return {name: max(of.values(), key=lambda b: abs(b.value)) for name, of in every.items()}


def cells(rows: Sequence[Row], mode: str, method: str) -> dict[str, dict[float, Interval]]:
    """By truth and share of noise, then by the shape's speed [km/h] (the car's), the bias [Hz]. Repetitions are
    independent; the mean of their wheels or records is one sample. Without an answer a record is left out."""
    found: dict[str, dict[float, Interval]] = {}
    car = [speed for _, speed, name in PRESSURE_CELLS if name == mode]
    for kind in ("known", "pressure"):
        words = _words(rows, kind, mode, method)
        if not len(words):
            continue
        error = words - (KNOWN[mode][0] if kind == "known" else words[:, :, :1])
        good = np.isfinite(error)
        with np.errstate(invalid="ignore"):
            mean = np.where(good, error, 0.0).sum(axis=3) / good.sum(axis=3)  # nan where there is no answer at all
        for i, share in enumerate(SHARES):
            columns = [column[np.isfinite(column)] for column in mean[:, :, i].T]
            speeds = [shape[0] for shape in KNOWN[mode][2]] if kind == "known" else car
            every = {v: mean_interval(c) for v, c in zip(speeds, columns, strict=True) if len(c)}
            if every:
                found[f"{kind}_{100.0 * share:g}"] = every
    return found


def table(rows: Sequence[Row]) -> Iterator[StudyRow]:
    """See `itpms_vibration`."""
    for mode, ending in (("antiphase", ""), ("in_phase", "_in_phase")):
        for method in METHODS:
            found = {name: b for name, b in biases(rows, mode, method).items() if not name.endswith("_0")}
            if not found:
                continue
            worst = max(found.values(), key=lambda b: abs(b.value))
            limit = MOST_BIAS if method == "vibration" and mode == "antiphase" else None
            yield StudyRow.of(f"{method}_bias_hz{ending}", "Hz", worst, limit=limit)
            for name, bias in found.items():
                truth, share = name.split("_")
                what = "known_process" if truth == "known" else "car"
                yield StudyRow.of(f"{method}_bias_hz{ending}_{what}_{share}_percent", "Hz", bias)
                of = cells(rows, mode, method)[name] if method == "vibration" else {}
                for speed, each in of.items() if len(of) > 1 else ():
                    yield StudyRow.of(f"{method}_bias_hz{ending}_{what}_{share}_percent_{speed:g}_km_h", "Hz", each)
    for _, speed, mode in PRESSURE_CELLS:
        words = _words(rows, "pressure", mode, "vibration")
        if len(words):
            axles = mode_at(speed, 1.0)
            expected = np.array([axles[axle][mode][0] for axle in ("front", "front", "rear", "rear")])
            yield StudyRow.of(
                f"vibration_minus_linearised_hz_{mode}", "Hz", mean_interval((words[:, 0, 0] - expected).mean(axis=1))
            )

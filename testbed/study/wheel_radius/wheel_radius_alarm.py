"""Study `wheel-radius-alarm`: how often does the wheel-radius alarm come on sound cars, in all that driving may be?

A repetition is one car of `sound_drives`: it learns on one drive, is then driven on DAYS others, and once more with 600
kg behind (LOADED), which is outside what the threshold was set on. Rows of `other_drives` are all but the loaded ones.
Alarms closer than GAP are one. Nearness: the smaller of the detector's statistic over its threshold and of the loss
over the least that matters, 1 at an alarm. By tail: its maxima of minutes, of which the largest SHARE are fitted, at 1;
limit: the design. Seeds 101 and 303 tuned the estimator and its threshold: report another.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from estimators.scores.false_alarms import false_alarms
from estimators.scores.interval import poisson_rate_interval
from estimators.scores.tail import block_maxima, fit_tail
from estimators.wheel_radius.thresholds import FALSE_PER_HOUR, MINUTE, SHARE
from estimators.wheel_radius.wheel_radius import WheelRadius
from testbed.study.study import Row, Study, StudyRow, Task
from testbed.study.wheel_radius.sound_drives import SoundCar, driven_cells, told

DAYS, LOADED = 3, 50  # drives of a car, and the number of the loaded one
BEHIND = {"payload": 600.0, "payload_position": (-1.2, 0.0, 0.0), "duration": 300.0}
SMALL = {"duration": 10.0, "manoeuvre": "constant", "friction": "1.0"}  # of every drive, in the small form
GAP = 60.0  # s between alarms that count as two
ICE = "0.2"


def drive_car(task: Task) -> Row:
    """By drive: `manoeuvre`, `friction`, `payload_kg`, `alarms` [s], `seconds` judged, and in each minute of them the
    greatest `nearness` of an alarm."""
    car, fields = SoundCar(task["seed"], task["number"]), SMALL if task["small"] else {}
    before = car.day(LOADED + 1, **fields) if task["small"] else car.calibration()
    learner = WheelRadius(told(before, car))
    learner.judge(driven_cells(before))
    learnt = learner.calibration()
    drives = []
    for number in (*range(1 if task["small"] else DAYS), LOADED):
        scenario = car.day(number, **((BEHIND if number == LOADED else {}) | fields))
        estimator = WheelRadius(told(scenario, car))
        if learnt is not None:
            estimator.use_calibration(learnt)
        out = estimator.judge(driven_cells(scenario))
        nearness = np.array(estimator.nearness)
        drives.append(
            {
                "loaded": number == LOADED,
                "manoeuvre": scenario.manoeuvre,
                "friction": scenario.friction,
                "payload_kg": scenario.payload,
                "seconds": len(nearness),
                "alarms": [float(alarm.time) for alarm in out.alarms],
                "nearness": _maxima(nearness),
            }
        )
    return {"calibrated": learnt is not None, "drives": drives}


def _maxima(nearness: NDArray[np.float64]) -> list[float]:
    """Of each minute of a drive."""
    return block_maxima(nearness, np.arange(len(nearness)), MINUTE).tolist() if len(nearness) else []


class WheelRadiusAlarmStudy(Study):
    name = "wheel-radius-alarm"
    about = "How often does the wheel-radius alarm call a sound tyre low, on any road, load and grip?"
    paper = "None; Persson, Gustafsson, Drevo, SAE 2002-01-1250, state no false-alarm rate."
    runs = 16

    @property
    def work(self) -> Callable[[Task], Row]:
        return drive_car

    def tasks(self, runs: int, seed: int, small: bool) -> list[Task]:
        return [{"seed": seed, "number": number, "small": small} for number in range(runs)]

    def table(self, rows: Sequence[Row]) -> list[StudyRow]:
        drives = [drive for row in rows for drive in row["drives"]]
        others = [drive for drive in drives if not drive["loaded"]]
        return [
            *_counted("other_drives", others),
            *_counted("country", [drive for drive in others if drive["manoeuvre"] == "country"]),
            *_counted("friction_0.2", [drive for drive in others if drive["friction"] == ICE]),
            *_counted("600_kg", [drive for drive in drives if drive["loaded"]]),
            *_tail(others),
        ]


def _counted(name: str, drives: Sequence[Row]) -> Iterator[StudyRow]:
    """Count, hours, rate with Garwood's interval, greatest nearness."""
    if sum(drive["seconds"] for drive in drives) == 0:
        yield StudyRow(f"hours_{name}", "h", here=0.0)
        return
    found = false_alarms([drive["alarms"] for drive in drives], [drive["seconds"] for drive in drives], GAP)
    ends = poisson_rate_interval(found.count, 1.0)
    yield StudyRow.of(f"false_alarms_{name}", "-", ends, limit=FALSE_PER_HOUR * found.hours)
    yield StudyRow(f"hours_{name}", "h", here=found.hours)
    yield StudyRow.of(f"false_alarms_per_hour_{name}", "1/h", found.rate, limit=FALSE_PER_HOUR)
    greatest = max(max(drive["nearness"], default=0.0) for drive in drives)
    yield StudyRow(f"greatest_nearness_{name}", "-", here=greatest, limit=1.0)


def _tail(drives: Sequence[Row]) -> Iterator[StudyRow]:
    """What the tail of the nearness says of the rate; nothing while there are too few drives."""
    maxima = [drive["nearness"] for drive in drives if len(drive["nearness"])]
    try:
        tail = fit_tail(maxima, MINUTE / 3600.0, SHARE)
        rate, nearness = tail.rate_at(1.0), tail.threshold_at(FALSE_PER_HOUR)
    except ValueError:
        return
    yield StudyRow.of("false_alarms_per_100_h_by_tail", "-", rate, limit=100.0 * FALSE_PER_HOUR, scale=100.0)
    yield StudyRow.of("nearness_once_in_100_h_by_tail", "-", nearness, limit=1.0)

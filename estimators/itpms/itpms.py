"""Estimator `itpms`: which tyres are low, by how much and how surely, without a pressure sensor.

Torsional vibration (`frequency_blocks`) and rolling radius (`contrasts`) of every BLOCK seconds against a calibration
by speed (`speed_bins`), judged by the likelihood of the 16 patterns of low tyres and of when the loss began
(`sound_car`, `patterns`, `monitor`) for both together and for each alone; alarms at one false alarm in 100 h (`alarm`,
`thresholds`). The published voting scheme (`voting`) runs beside. Estimates each block:

    WHEEL/pressure_change    relative to the calibration, at the present warmth [-]; the std is the stated confidence:
                             it is WIDE where nothing can be read, and grows while nothing is
    WHEEL/low_probability    even odds of some loss at the threshold [-], std of such a yes or no
    fused_statistic, vibration_statistic, radius_statistic     [nats]
    WHEEL/vibration_flag, WHEEL/radius_flag     1 once the source alone has alarmed for that wheel
    WHEEL/voting_flag        1 once the voting scheme has warned
    vibration_confidence, radius_confidence     c_1, c_2 of the voting scheme [nats]
    agreed_confidence        their mean where both analyses mean the same tyres, else 0 [nats]

After a reset (no calibration given, or `relearn`) it learns for LEARNING blocks and gives no alarm. A change of all
four pressures with the weather is a change of pressure and shows; an equal loss in all four is seen by vibration alone.
Left out: spare wheels of another size, chains.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.drive_log import WHEELS, Signal
from estimators.estimator import Alarm, Estimate, Estimator, Flag, Outputs
from estimators.grid import LATENCY, REPEAT, Grid
from estimators.itpms.alarm import AlarmRule, Named
from estimators.itpms.contrasts import Contrasts
from estimators.itpms.frequency_blocks import DELAY, EDGES, FrequencyBlocks
from estimators.itpms.learning import LearningBlock, learn
from estimators.itpms.mode_grid import BLOCK
from estimators.itpms.monitor import SOURCES, Block, Monitor
from estimators.itpms.patterns import Judgement
from estimators.itpms.speed_bins import Calibration
from estimators.itpms.summary import summary
from estimators.itpms.thresholds import TUNED
from estimators.itpms.voting import Vote, agreed, warning
from estimators.itpms.warming import Warming
from estimators.wheel_radius.motion import CHANNELS, MotionTracker

CELL = 0.1  # s
CELLS = round(BLOCK / CELL)
LEARNING = 300  # blocks with something read
LONGEST_SILENCE = 3600.0  # s without any sample, over which the clock jumps
TEETH = "teeth"
SPEEDS = tuple(f"wheel/{wheel}/speed" for wheel in WHEELS)
Row = tuple[float, dict[str, tuple[float, float]]]


class Itpms(Estimator):
    name = "itpms"
    reads = (*EDGES, *(channel.signal for channel in CHANNELS if channel.column in (None, 2)), "imu/accel")
    requires = ()  # each wheel and each source speaks for itself, and
    requires_any = (*EDGES, *SPEEDS)

    def __init__(self, car: Car) -> None:
        super().__init__(car)
        self._grid, self._tracker = Grid(CHANNELS, CELL), MotionTracker(car, CELL)
        self._contrasts, self._frequencies = Contrasts(car, CELLS), FrequencyBlocks(car)
        self._cells: list[tuple[int, float, NDArray[np.float64]]] = []
        self._second: int | None = None
        self._heard = False
        self._warming = Warming(BLOCK)
        self._raised: dict[str, float] = {}
        self._teeth: dict[str, Any] = {}
        self.relearn()

    def relearn(self) -> None:
        """Forget the calibration and learn anew: the driver has set the pressures."""
        self._calibration: Calibration | None = None
        self._learning: list[LearningBlock] = []
        self._start()

    def _start(self) -> None:
        calibration = self._calibration
        self._monitors = {} if calibration is None else {s: Monitor(self.car, calibration, s) for s in SOURCES}
        self._rules = {source: AlarmRule(TUNED.alone[source]) for source in SOURCES}
        self._voted: set[str] = set()
        self._unread = 0.0

    def use_calibration(self, document: Mapping[str, Any]) -> None:
        """Start calibrated."""
        teeth = document.get(TEETH, {})
        if not isinstance(teeth, Mapping):
            raise ValueError(f"calibration has teeth {teeth!r}, valid: a mapping by wheel")
        self._calibration = Calibration.from_document(document)
        self._frequencies.use_calibration(teeth)
        self._teeth = dict(teeth)
        self._start()

    def calibration(self) -> dict[str, Any] | None:
        """Levels by speed, and the wheels' tooth rings; of what was learnt so far while learning."""
        known = self._calibration or learn(self._learning)
        return None if known is None else known.document() | {TEETH: self._teeth | self._frequencies.calibration()}

    def update(self, samples: Mapping[str, Signal], until: float) -> Outputs:
        """See `Estimator.update`."""
        flags = self._flags(self._frequencies.add(samples)) + self._grid.add(samples)
        cells, more = self._grid.close(until)
        flags += more
        self._cells += zip(cells.index.tolist(), cells.centre.tolist(), cells.value, strict=True)
        rows: list[Row] = []
        alarms: list[Alarm] = []
        last = math.floor(until - LATENCY + 1e-9)
        while (second := self._following(last)) is not None:
            flags += self._flags(self._frequencies.second(second))
            number, rest = divmod(second + 1 - DELAY, BLOCK)
            if rest == 0.0 and number >= 1.0:
                self._conclude(int(number) - 1, second + 1.0, rows, alarms, flags)
        return Outputs(_columns(rows), tuple(alarms), tuple(sorted(flags)))

    def _following(self, last: int) -> int | None:
        """The next whole second to work on, before `last`, up to which a sample waits; None if there is none."""
        cells = self._cells
        earliest = min(self._frequencies.earliest, cells[0][1] if cells else math.inf)
        latest = max(self._frequencies.latest, cells[-1][1] if cells else -math.inf)
        if self._second is None or (math.isfinite(earliest) and earliest - self._second > LONGEST_SILENCE):
            if not math.isfinite(earliest):
                return None
            self._second = math.floor(earliest)
        if self._second >= last or self._second > latest:
            return None
        self._second += 1
        return self._second - 1

    def _conclude(self, number: int, time: float, rows: list[Row], alarms: list[Alarm], flags: list[Flag]) -> None:
        """Take block `number` at the clock `time` [s]."""
        block = self._block(number)
        if self._calibration is None:
            self._learn(block, time, flags)
        judgements = {source: monitor.step(block) for source, monitor in self._monitors.items()}
        read = bool(np.isfinite(block.frequency[..., 0]).any() or len(block.radius.value) > 0)
        self._unread = 0.0 if read else self._unread + BLOCK
        for source, rule in self._rules.items():
            named = rule.step(judgements.get(source))
            if named is not None and source == "fused":
                alarms.append(Alarm(time, self._text(named), named.wheels))
        self._heard |= math.isfinite(block.speed) or len(block.radius.value) > 0
        if self._heard:
            rows.append((time, self._said(judgements)))

    def _block(self, number: int) -> Block:
        while self._cells and self._cells[0][0] < CELLS * (number + 1):
            index, centre, value = self._cells.pop(0)
            self._contrasts.add(self._tracker.motion(index, centre, value))
        radius, frequency = self._contrasts.close(), self._frequencies.block(number)
        speed = radius.speed
        if math.isnan(speed) and np.isfinite(self._frequencies.omega).any():
            speed = float(np.nanmean(self._frequencies.omega)) * self.car.rolling_radius
        return Block(number, frequency, radius, speed, self._warming.step(number, speed))

    def _learn(self, block: Block, time: float, flags: list[Flag]) -> None:
        row = block.as_learning()
        if row is not None:
            self._learning.append(row)
        if len(self._learning) >= LEARNING:
            self._calibration = learn(self._learning)
            self._learning = []
            self._start()
            flags.append(Flag(time, f"calibrated on {LEARNING * BLOCK:g} s of driving"))

    def _said(self, judgements: Mapping[str, Judgement | None]) -> dict[str, tuple[float, float]]:
        """Estimates of this block, name -> value and std."""
        fused = judgements.get("fused")
        change, std, low = summary(fused, TUNED.alone["fused"], self._unread)
        said: dict[str, tuple[float, float]] = {}
        votes = {source: Vote.of(judgements.get(source)) for source in SOURCES[:2]}
        self._voted |= set(warning(votes["vibration"], votes["radius"], TUNED.voting))
        said["agreed_confidence"] = (agreed(votes["vibration"], votes["radius"]), 0.0)
        for w, wheel in enumerate(WHEELS):
            said[f"{wheel}/pressure_change"] = (float(np.expm1(change[w])), float(std[w]))
            said[f"{wheel}/low_probability"] = (float(low[w]), float(np.sqrt(low[w] * (1.0 - low[w]))))
            for source in SOURCES[:2]:
                said[f"{wheel}/{source}_flag"] = (float(wheel in self._rules[source].wheels), 0.0)
            said[f"{wheel}/voting_flag"] = (float(wheel in self._voted), 0.0)
        for source in SOURCES[:2]:
            said[f"{source}_confidence"] = (votes[source].confidence, 0.0)
        for source, judgement in judgements.items():
            if judgement is not None:
                said[f"{source}_statistic"] = (judgement.statistic, 0.0)
        return said

    def _text(self, named: Named) -> str:
        judgement = named.judgement
        lost = -100.0 * np.expm1(judgement.change[judgement.best])
        sure = 100.0 * judgement.certainty
        return (
            f"low pressure: {lost.mean():.0f} % lost (std {100.0 * judgement.std[judgement.best].mean():.0f}), "
            f"{sure:.0f} % sure of the tyres; false alarms: one in 100 h"
        )

    def _flags(self, complaints: list[tuple[float, str]]) -> list[Flag]:
        """Complaints in time order, the same text at most once in `REPEAT` seconds."""
        flags = []
        for time, text in sorted(complaints):
            if time - self._raised.get(text, -math.inf) >= REPEAT:
                self._raised[text] = time
                flags.append(Flag(time, text))
        return flags


def _columns(rows: list[Row]) -> dict[str, Estimate]:
    """Rows of a time and its estimates -> one estimate per name."""
    columns: dict[str, list[tuple[float, float, float]]] = {}
    for time, said in rows:
        for name, (value, std) in said.items():
            columns.setdefault(name, []).append((time, value, std))
    return {
        name: Estimate(table[:, 0].copy(), table[:, 1].copy(), table[:, 2].copy())
        for name, table in ((name, np.array(column)) for name, column in columns.items())
    }

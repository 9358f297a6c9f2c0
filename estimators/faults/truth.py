"""Faults as truth signals, for plots and scores; no estimator may read them.

truth/fault/SENSOR      text: kind and numbers as typed from the fault's start, "" from its end
truth/sound/SIGNAL      what the sound sensor says during a fault (edges left out)
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from estimators.drive_log import Signal
from estimators.faults.fault import Fault
from estimators.faults.injector import EDGES, touched


def fault_events(faults: Iterable[Fault], since: float, until: float) -> dict[str, Signal]:
    """Beginnings and ends with since <= time < until [s]."""
    events: dict[str, list[tuple[float, str]]] = {}
    for fault in faults:
        for time, text in ((fault.start, fault.what), (fault.end, "")):
            if since <= time < until:
                events.setdefault(f"truth/fault/{fault.target.name}", []).append((time, text))
    return {
        name: Signal([t for t, _ in sorted(found)], np.array([s for _, s in sorted(found)], dtype=object))
        for name, found in events.items()
    }


def sound_signals(faults: Iterable[Fault], signals: Mapping[str, Signal]) -> dict[str, Signal]:
    """The samples of sound signals that a fault is about to change."""
    found = {}
    for name in {name for fault in faults for name in touched(fault) if name in signals and not name.endswith(EDGES)}:
        signal = signals[name]
        inside = np.zeros(len(signal), dtype=bool)
        for fault in faults:
            if name in touched(fault):
                inside |= (signal.time >= fault.start) & (signal.time < fault.end)
        if inside.any():
            found[f"truth/sound/{name}"] = Signal(signal.time[inside], signal.value[inside], signal.unit, signal.frame)
    return found

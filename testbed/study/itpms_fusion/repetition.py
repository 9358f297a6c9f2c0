"""One repetition: its drives driven with the estimator in the car, and what it said, as JSON text in `drives`.

For each drive by name: `wheels`, `onset_s`, `reached_s` (when the share is lost), `end_s`, `driven_s` before the onset,
`alarms`: {method: [[time_s, [wheel, ...]], ...]} for the fused estimator, vibration and radius alone and the voting
scheme; `largest`: {method: [largest statistic of each SPAN before the onset]}; `bound_s`: from the loss to what the
vibration's Cramer-Rao bound allows (`bound`), `wander_s`: the same of a car that wanders as declared. A drive ends
early once every method that can see the loss has alarmed.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.drive_log import WHEELS, Signal
from estimators.itpms.mode_grid import BLOCK
from estimators.itpms.thresholds import SPAN
from testbed.campaign.variants import variant_of
from testbed.session import Session, Variant
from testbed.simulation import Diverged
from testbed.study.itpms_fusion.bound import detection_bound, wandering_bound
from testbed.study.itpms_fusion.drives import Drive, drives
from testbed.tyre.inflation import PRESSURE

METHOD = "itpms"
METHODS = ("fused", "vibration", "radius", "voting")
HARDEST = 0.10  # share lost up to which the bound of a wandering car is computed
AFTER = 6.0  # s that a drive goes on after the last alarm that is waited for


def task(seed: int, number: int, small: bool) -> dict[str, Any]:
    """The drives of repetition `number`."""
    return {"drives": [drive.as_json() for drive in drives(seed, number, small)], "believed": _believed(seed, number)}


def _believed(seed: int, number: int) -> dict[str, Any]:
    from testbed.study.itpms_fusion.cars import RepetitionCar

    return RepetitionCar(seed, number).believed


def repeat(task: dict[str, Any]) -> dict[str, Any]:
    """The row of a repetition."""
    learnt: dict[str, Any] = {}
    found: dict[str, Any] = {}
    for values in task["drives"]:
        drive = Drive.from_json(values)
        if not drive.name.endswith("calibration"):
            if learnt.get(drive.calibration) is not None:
                found[drive.name] = _driven(drive, task["believed"], learnt[drive.calibration])
            continue
        learnt[drive.name] = _learn(drive, task["believed"])
    return {"drives": json.dumps(found)}


def _session(drive: Drive, believed: Mapping[str, Any], learnt: Mapping[str, Any] | None) -> Session:
    variant = variant_of(drive.scenario, {}, drive.tyre, believed, {METHOD: learnt} if learnt else None)
    only = Variant(variant.vehicle, variant.tyre, variant.car, variant.calibrations, only_read=True)
    return Session(drive.scenario, None, [METHOD], only)


def _learn(drive: Drive, believed: Mapping[str, Any]) -> dict[str, Any] | None:
    with _session(drive, believed, None) as session:
        for _ in session.run():
            pass
        return session.bank.calibrations().get(METHOD)


def _driven(drive: Drive, believed: Mapping[str, Any], learnt: Mapping[str, Any]) -> dict[str, Any]:
    said: dict[str, list[Signal]] = {}
    speed: list[float] = []
    reached = drive.onset + drive.within
    waited = [m for m in METHODS if not (m == "radius" and len(drive.wheels) == 4)]
    end, warned, error = 0.0, dict.fromkeys(METHODS, np.inf), None
    with _session(drive, believed, learnt) as session:
        inflation, gas = session.simulation.constants.inflation, session.simulation.state.gas
        try:
            for stretch, words in session.run():
                end = float(stretch["time"][-1]) + drive.scenario.step
                speed.append(float(np.hypot(stretch["velocity"][:, 0], stretch["velocity"][:, 1]).mean()))
                for name, signal in words.items():
                    said.setdefault(name, []).append(signal)
                if drive.onset and round(end) == round(drive.onset):  # the share is of the pressure of the moment
                    for wheel in drive.wheels:
                        w = WHEELS.index(wheel)
                        inflation.set_pressure[w] = (1.0 - drive.share) * gas[w, PRESSURE]
                for method, found in _alarms(session, words).items():
                    warned[method] = min(warned[method], *(t for t, _ in found)) if found else warned[method]
                over = max(warned[m] for m in waited)
                if drive.wheels and end > max(over, reached) + AFTER:
                    break
        except Diverged as why:  # what was driven counts
            error = str(why)
        fused = [(a.time, list(a.wheels)) for a in session.bank.alarms[METHOD]]
    alarms = {method: _changes(said, method) for method in METHODS[1:]} | {"fused": fused}
    sound = drive.onset if drive.onset else 0.0 if drive.wheels else end
    return {
        "wheels": list(drive.wheels), "share": drive.share, "onset_s": drive.onset, "reached_s": reached, "end_s": end,
        "sound_s": min(sound, end), "ended": error, "alarms": alarms,
        "largest": {m: _largest(said, f"{m}_statistic", min(sound, end)) for m in METHODS[:3]},
        "bound_s": _bound(drive, speed), "wander_s": _wander(drive, speed),
        "speed_kmh": 3.6 * float(np.mean(speed)), "fastest_kmh": 3.6 * max(speed),
        "manoeuvre": drive.scenario.manoeuvre, "road": drive.scenario.road,
        "statistics": _series(said) if drive.name in ("15x1_sudden", "25x1_sudden", "sound") else None,
    }  # fmt: skip


def _bound(drive: Drive, speed: list[float]) -> float | None:
    if not drive.wheels:
        return None
    return detection_bound(np.array(speed), drive.onset, drive.within, len(drive.wheels), drive.share)


def _wander(drive: Drive, speed: list[float]) -> float | None:
    """Of the loss of 10 %, the one for which the vibration alone may not do."""
    if not drive.wheels or drive.share > HARDEST:
        return None
    return wandering_bound(np.array(speed), drive.onset, drive.within, len(drive.wheels), drive.share)


def _alarms(session: Session, words: Mapping[str, Signal]) -> dict[str, list[tuple[float, str]]]:
    """Times of what each method says in a stretch that is an alarm: fused ones once, flags while they are up."""
    found: dict[str, list[tuple[float, str]]] = {"fused": [(a.time, "") for a in session.bank.alarms[METHOD]]}
    for method in METHODS[1:]:
        flags = [words[f"est/{METHOD}/{w}/{method}_flag"] for w in WHEELS if f"est/{METHOD}/{w}/{method}_flag" in words]
        found[method] = [(float(f.time[i]), "") for f in flags for i in np.flatnonzero(f.value > 0.5)]
    return found


def _joined(said: Mapping[str, list[Signal]], name: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    parts = said.get(f"est/{METHOD}/{name}", [])
    if not parts:
        return np.empty(0), np.empty(0)
    return np.concatenate([p.time for p in parts]), np.concatenate([p.value for p in parts])


def _changes(said: Mapping[str, list[Signal]], method: str) -> list[tuple[float, list[str]]]:
    """When the set of flagged wheels of a method grew, and to which."""
    columns = [_joined(said, f"{wheel}/{method}_flag") for wheel in WHEELS]
    if not len(columns[0][0]):
        return []
    flags = np.stack([value > 0.5 for _, value in columns], axis=1)
    grown = np.flatnonzero(flags.any(axis=1) & (flags != np.vstack([np.zeros((1, 4), bool), flags[:-1]])).any(axis=1))
    return [(float(columns[0][0][i]), [w for w, up in zip(WHEELS, flags[i], strict=True) if up]) for i in grown]


def _largest(said: Mapping[str, list[Signal]], name: str, end: float) -> list[float]:
    """Largest of a statistic in each whole SPAN before `end` [s]."""
    time, value = _joined(said, name)
    spans = np.floor((time - BLOCK) / SPAN).astype(int)
    whole = int(max(end - BLOCK, 0.0) // SPAN)
    return [float(value[spans == k].max()) for k in range(whole) if (spans == k).any()]


def _series(said: Mapping[str, list[Signal]]) -> dict[str, list[float]]:
    """Confidences of the voting scheme over time, for its figure; both are said in every block."""
    columns = {name: _joined(said, name) for name in ("vibration_confidence", "radius_confidence")}
    time = columns["vibration_confidence"][0].tolist()
    return {"time_s": time} | {name: np.round(value, 3).tolist() for name, (_, value) in columns.items()}

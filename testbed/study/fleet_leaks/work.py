"""A task's row: the record as it is, or one repetition of the trials on the trailers that nothing was tuned on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from testbed.study.fleet_leaks.fleet import read_fleet
from testbed.study.fleet_leaks.record import of_trailer
from testbed.study.fleet_leaks.trials import RATES, REPLICATES, false_alarms, innovations, leak, sound_tyres

SMALL_TYRES, SMALL_REPLICATES = 2, 2


def repeat(task: dict[str, Any]) -> dict[str, Any]:
    """The row of a task: `trailers`, or `leaks` by rate and `blocks`."""
    fleet = read_fleet(Path(task["data"]))
    if task["kind"] == "record":
        return {"trailers": [of_trailer(trailer) for trailer in fleet]}
    rng = np.random.default_rng(task["seed"])
    held_out = tuple(trailer for trailer in fleet if not trailer.tuning)
    sound = sound_tyres(held_out)
    white = innovations(held_out, sound)
    chosen = sound[:SMALL_TYRES] if task["small"] else sound
    leaks = {f"{rate:g}": [leak(held_out[n], tyre, rate, rng) for n, tyre in chosen] for rate in RATES}
    return {
        "leaks": {name: [one for one in every if one is not None] for name, every in leaks.items()},
        "blocks": false_alarms(white, SMALL_REPLICATES if task["small"] else REPLICATES, rng) if white else [],
    }

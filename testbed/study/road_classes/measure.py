"""What is measured on one drive: the row of a cell and seed.

    driven                                1 if the car was still upright and made half of its way, else 0 and the rest
                                          is missing
    ride                                  r.m.s. vertical acceleration at the centre of gravity, weighted Wk [m/s^2]
    load_variation/AXLE                   standard deviation of a tyre's load over its mean [-]; left and right are
                                          averaged here and below
    hop/AXLE                              wheel hop, undamped, from the hubs' spectrum [Hz]
    in_phase/AXLE, antiphase/AXLE         rotation of rim and belt, undamped, from the wheel speeds' spectrum [Hz]
    KIND_std/AXLE, KIND_damping/AXLE      std of these [Hz], damping ratio [-]
    radius/AXLE, stiffness/AXLE           effective rolling radius [m], dFz/drho [N/m], means over the drive
    error/RESIDUAL, std/RESIDUAL          last estimate of `wheel_radius` less the truth, and its reported std [-]

A frequency that the spectrum does not hold, `resolved`, is missing.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.wheel_radius.residuals import MIXING, NAMES
from testbed.campaign.variants import variant_of
from testbed.measures.resonance import Resonance, rotation, wheel_hop
from testbed.measures.weighting import weighted_rms
from testbed.scenario import Scenario
from testbed.session import Session
from testbed.simulation import Diverged
from testbed.trace import column

ON_ROAD = 4.0  # m from which on all wheels are on the road, not on the flat run-in
SLOWEST = 0.5  # share of the wanted speed below which the car was stuck
# resonance: largest std [Hz] and damping ratio at which a spectrum holds it: on a broader peak the slope of what
# excites it decides where the fit puts it
LIMITS = {"hop": (1.0, 0.6), "in_phase": (1.0, 0.2), "antiphase": (1.0, 0.2)}
AXLES = (("front", [0, 1]), ("rear", [2, 3]))
METHOD = "wheel_radius"


def measure(task: dict[str, Any]) -> dict[str, Any]:
    """The row of a task of `cells`."""
    scenario = Scenario.from_notes(task["scenario"])
    variant = variant_of(scenario, task["vehicle"], task["tyre"], {})
    row: dict[str, Any] = {"cell": task["cell"], "seed": task["seed"], "driven": 0}
    said: dict[str, float] = {}
    parts = []
    with Session(scenario, None, [METHOD], variant) as session:
        try:
            for stretch, words in session.run():
                parts.append(stretch.rows)
                said |= {name: float(s.value[-1]) for name, s in words.items() if name.startswith("est/") and len(s)
                         and s.value.dtype.kind == "f"}  # fmt: skip
        except Diverged:
            return row
    rows = np.concatenate(parts)
    position = column(rows, "position")[:, :2]
    way = float(np.linalg.norm(np.diff(position, axis=0), axis=1).sum())
    if way < SLOWEST * scenario.speed * scenario.duration:
        return row
    on_road = rows[int(np.argmax(position[:, 0] >= ON_ROAD)) :]
    return row | {"driven": 1} | _motion(on_road, 1.0 / scenario.step) | _errors(on_road, said)


def resolved(kind: str, resonance: Resonance) -> bool:
    """Whether a spectrum holds the resonance."""
    std, damping = LIMITS[kind]
    return resonance.std <= std and resonance.damping < damping


def _motion(rows: NDArray[np.float64], rate: float) -> dict[str, float | None]:
    """Physics of the drive; rate: rows per second."""
    found: dict[str, float | None] = {"ride": weighted_rms(column(rows, "accel")[:, 2], rate)}
    load, hub, rim, radius, stiffness = (
        column(rows, name) for name in ("load", "hub_accel_z", "rim_speed", "rolling_radius", "stiffness")
    )
    for axle, wheels in AXLES:
        left, right = wheels
        found[f"load_variation/{axle}"] = float(np.mean(load[:, wheels].std(axis=0) / load[:, wheels].mean(axis=0)))
        found[f"radius/{axle}"] = float(radius[:, wheels].mean())
        found[f"stiffness/{axle}"] = float(stiffness[:, wheels].mean())
        in_phase, antiphase = rotation(rim[:, left], rim[:, right], rate)
        hop = wheel_hop(hub[:, left], hub[:, right], rate)
        for kind, resonance in (("hop", hop), ("in_phase", in_phase), ("antiphase", antiphase)):
            found[f"{kind}/{axle}"] = resonance.frequency if resolved(kind, resonance) else None
            found[f"{kind}_std/{axle}"] = resonance.std
            found[f"{kind}_damping/{axle}"] = resonance.damping
    return found


def _errors(rows: NDArray[np.float64], said: dict[str, float]) -> dict[str, float | None]:
    """Estimates against the truth; missing where none was given."""
    radius = column(rows, "rolling_radius").mean(axis=0)
    truth = MIXING @ np.log(radius)  # of small differences, to second order
    found: dict[str, float | None] = {}
    for name, true in zip(NAMES, truth, strict=True):
        value, std = said.get(f"est/{METHOD}/{name}"), said.get(f"est/{METHOD}/{name}/std")
        found[f"error/{name}"] = None if value is None else value - float(true)
        found[f"std/{name}"] = std
    return found

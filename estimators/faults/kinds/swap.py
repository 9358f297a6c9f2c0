"""Plugs exchanged: a wheel's sensor and that of the other side of its axle give each other's signals."""

from __future__ import annotations

from estimators.faults.kind import SwapFault


class Swap(SwapFault):
    name = "swap"
    about = "exchanged with the other side of the axle"

"""On a road that nobody hears, hubs tell no pressure: the estimates stay where the prior has them, and say so."""

from __future__ import annotations

import pytest

from testbed.drive import drive
from testbed.scenario import Scenario


@pytest.mark.parametrize("method", ["vertical_pressure", "axles"])
def test_a_flat_road_tells_nothing(method: str) -> None:
    said = drive(Scenario(road="flat", speed=15.0, duration=8.0), None, [method])["estimates"]
    for wheel in ("fl", "fr", "rl", "rr"):
        entry = said.get(f"est/{method}/{wheel}/pressure")
        assert entry is None or abs(entry["value"] - 250e3) < entry["std"]
        assert entry is None or entry["std"] > 30e3

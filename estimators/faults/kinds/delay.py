"""Late messages: stamp = stamp + d. A sample comes when the clock has reached its new stamp."""

from __future__ import annotations

from estimators.faults.kind import DelayFault, Number


class Delay(DelayFault):
    name = "delay"
    about = "messages come later"
    numbers = (Number("SECONDS", "s", 0.0, 60.0),)

    @property
    def seconds(self) -> float:
        return self.given[0]

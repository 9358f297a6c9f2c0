"""Numbers as the thesis prints them: Razavi, Error Detection in the Active Front Steering system, Lund 2006.

Its figures' curves are pictures without numbers; these are what captions, tables and text say.
"""

from __future__ import annotations

from dataclasses import dataclass

RATE = 100.0  # Hz, of all its sequences: sample time 0.01 s
CHANGE_AT = 45.0  # s, of the mean in Figures 4.7 to 4.12
FALSE_ALARMS_4_7 = 8  # before the change, h = 0.3995
MEAN_CURVES = (("4.1", 1.0, 200.0), ("4.2", 5.0, 200.0), ("4.3", 1.0, 2e6))  # MTD(nu): figure, sigma, 1/FAR
THETAS = (5.0, 10.0, 15.0)


@dataclass(frozen=True)
class Threshold:
    """One of the twelve. theta: change of the mean; variance: what the figure calls sigma^2; asked: 1/FAR [samples]."""

    figure: str
    theta: float
    variance: float
    asked: float
    printed: float

    @property
    def name(self) -> str:
        """Figure and threshold."""
        return f"{self.figure} h {self.printed:g}"

    @property
    def drift(self) -> float:
        """nu = theta / 2, always."""
        return 0.5 * self.theta


THRESHOLDS = tuple(
    Threshold(figure, theta, variance, asked, h)
    for figure, theta, variance, both in (
        ("4.7", 5.0, 1.0, (0.3995, 2.2409)),
        ("4.8", 5.0, 5.0, (17.4711, 63.2476)),
        ("4.9", 10.0, 1.0, (-0.2449, 0.6761)),
        ("4.10", 10.0, 5.0, (9.1921, 32.1745)),
        ("4.11", 15.0, 1.0, (-0.4979, 0.1161)),
        ("4.12", 15.0, 5.0, (5.5217, 20.8579)),
    )
    for asked, h in zip((200.0, 2e6), both, strict=True)
)


@dataclass(frozen=True)
class VarianceChange:
    """Figures 4.27 to 4.32: variances before and after, theta, thresholds for "ARL" 0.5 and 1 (None: "h < 0")."""

    figure: str
    before: float
    after: float
    theta: float
    thresholds: tuple[float | None, float | None]


VARIANCE_CHANGES = (
    VarianceChange("4.27", 1.0, 3.0, 2.7177, (51.0, 98.0)),
    VarianceChange("4.28", 1.0, 5.0, 4.0503, (33.0, 65.0)),
    VarianceChange("4.29", 3.0, 5.0, 4.8963, (24.0, 47.0)),
    VarianceChange("4.30", 3.0, 10.0, 8.8814, (5.0, 9.0)),
    VarianceChange("4.31", 5.0, 10.0, 9.6261, (4.0, 6.0)),
    VarianceChange("4.32", 5.0, 20.0, 17.0955, (None, None)),
)
VARIANCE_ARLS = (0.5, 1.0)


@dataclass(frozen=True)
class Conformed:
    """Residuals of Figures 4.14 to 4.17 with |r| > cut removed (and zeros), and the design for them in 4.18 to 4.21.

    sigma: as printed; theta_of_variance: of its table "Test on Residuals - Variance Change", sigma + 0.01 the change.
    """

    figure: str
    tested: str
    cut: float
    zeros: bool
    sigma: float
    drift: float
    threshold: float
    theta_of_variance: float


CONFORMED = (
    Conformed("4.14", "4.18", 50.0, True, 15.7, 20.0, 92.5, 247.75),
    Conformed("4.15", "4.19", 100.0, True, 20.7, 20.0, 162.6, 748.45),
    Conformed("4.16", "4.20", 200.0, True, 33.1, 35.0, 237.1, 4.89e3),
    Conformed("4.17", "4.21", 100.0, False, 21.9, 20.0, 182.2, 937.64),
)
CONFORMED_ASKED = 2e7  # samples, 1/FAR
SIGMA_STEP = 0.01  # sigma_1 - sigma_0 of the table
TABLE_ARLS = ((1.0, 1.61e50), (2.0, 3.22e50), (3.0, 4.83e50), (4.0, 6.44e50))  # of 4.14: h, "ARL"


@dataclass(frozen=True)
class ScenarioTuning:
    """Table 5.1: a CUSUM that "would work" in a scenario whose residuals lie between low and high."""

    name: str
    low: float
    high: float
    drift: float
    threshold: float


TABLE_5_1 = (
    ScenarioTuning("scenario_01", -1080.0, 1266.0, 200.0, 20000.0),
    ScenarioTuning("scenario_02", -36.0, 31.0, 25.0, 1000.0),
)

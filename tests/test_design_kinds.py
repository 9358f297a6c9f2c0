"""Claims about the design of every kind: it has the run length asked for, by simulation; what cannot be is refused."""

from __future__ import annotations

from collections.abc import Callable
from math import inf

import numpy as np
import pytest

from estimators.detectors import (
    CusumMean,
    CusumVariance,
    Design,
    Glr,
    RunLength,
    design_cusum_mean,
    design_cusum_variance,
    design_ewma,
    design_glr,
    design_integrator,
    design_local_cusum,
    gaussian,
    run_lengths,
    samples_between,
    simulated_run_length,
)

ALARMS = 2000
SIGMAS = 4.0  # of the simulation's standard error: 1 in 16000 for each comparison, and the seeds are fixed
CALIBRATION = 0.045  # relative 95 % half-width that a design by simulation states, at most

KINDS: dict[str, Callable[[float], Design]] = {
    "cusum": lambda arl0: design_cusum_mean(1.0, arl0),
    "cusum lower": lambda arl0: design_cusum_mean(0.5, arl0, "lower"),
    "cusum two-sided": lambda arl0: design_cusum_mean(1.0, arl0, "both"),
    "cusum variance up": lambda arl0: design_cusum_variance(1.0, 3.0, arl0),
    "cusum variance down": lambda arl0: design_cusum_variance(5.0, 1.0, arl0),
    "gma": lambda arl0: design_ewma(1.0, arl0),
    "gma two-sided": lambda arl0: design_ewma(1.0, arl0, "both", 0.9),
    "glr two-sided": lambda arl0: design_glr(1.0, arl0, window=10),
    "glr lower": lambda arl0: design_glr(2.0, arl0, "lower"),
    "local cusum": lambda arl0: design_local_cusum(1.0, arl0, (2.0,)),
    "double local cusum": lambda arl0: design_local_cusum(1.0, arl0, (2.0,), "both"),
    "local and global cusum": lambda arl0: design_local_cusum(1.0, arl0, (1.5, inf)),
    "double local and global cusum": lambda arl0: design_local_cusum(1.0, arl0, (2.0, inf), "both"),
    "ac": lambda arl0: design_integrator(3.0, arl0, period=1),
    "acf": lambda arl0: design_integrator(1.0, arl0),
    "acs": lambda arl0: design_integrator(0.5, arl0, "upper", period=60),
}


@pytest.fixture(autouse=True)
def short_simulations(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the designs: 3.6 % (95 %) for 2 %, and extrapolation from 1500 samples on."""
    for kind in ("glr", "local_cusum"):
        monkeypatch.setattr(f"estimators.detectors.{kind}.ALARMS", 3000)
    monkeypatch.setattr("estimators.detectors.local_cusum.SIMULATED", 1500.0)


def assert_agree(said: RunLength, seen: RunLength) -> None:
    """The simulation's interval widened to `SIGMAS`, and the stated interval of what is not exact."""
    error = (seen.high - seen.low) / 3.92 * SIGMAS
    assert said.low - error <= seen.mean <= said.high + error


def changed(design: Design) -> dict[str, float]:
    """Mean or standard deviation of the residuals after the change."""
    if not isinstance(design.detector, CusumVariance):
        return {"mean": -design.change if design.detector.sides == "lower" else design.change}
    return {"std": design.change**0.5}


@pytest.mark.parametrize("arl0", [100.0, 600.0])
@pytest.mark.parametrize("kind", KINDS)
def test_run_lengths_are_those_of_a_simulation(kind: str, arl0: float) -> None:
    design = KINDS[kind](arl0)
    assert design.arl0.mean == pytest.approx(arl0, rel=1e-3 if design.arl0.method == "integral equation" else 0.05)
    assert design.arl0.high - design.arl0.mean <= CALIBRATION * arl0
    assert_agree(design.arl0, simulated_run_length(design.detector, alarms=ALARMS, seed=1))
    assert_agree(design.delay, simulated_run_length(design.detector, **changed(design), alarms=ALARMS, seed=2))
    assert design.delay.mean < 0.4 * arl0


def test_a_glr_can_be_designed_for_one_false_alarm_in_100_hours() -> None:
    """ln(10) of threshold is about a factor of 10 of run length, a little less as the threshold itself counts too."""
    design = design_glr(2.0, 3.6e7, window=8)
    assert design.arl0.method == "importance sampling"
    assert design.arl0.low < 3.6e7 < design.arl0.high
    earlier = Glr(8, design.detector.level - np.log(10.0), "both").average_run_length()
    assert 8.0 < design.arl0.mean / earlier.mean < 10.5


def test_several_local_cusums_are_extrapolated_beyond_what_is_simulated() -> None:
    design = design_local_cusum(1.0, 1e7, (2.0, inf))
    assert design.arl0.method == "simulation, extrapolated"
    assert design.arl0.mean == pytest.approx(1e7, rel=0.1)
    assert design.arl0.low == pytest.approx(design.detector.bounds()[0])  # type: ignore[attr-defined]
    assert design.arl0.low <= design.arl0.mean <= design.arl0.high


def test_for_its_shift_no_kind_is_quicker_than_the_cusum() -> None:
    """Lorden and Moustakides: at the same run length; the zero-state delay of a GMA may be a little shorter."""
    cusum = design_cusum_mean(1.0, 600.0).delay.mean
    for kind in ("gma", "local cusum", "local and global cusum"):
        assert KINDS[kind](600.0).delay.mean > 0.93 * cusum
    for other in (0.35, 0.65):
        assert design_cusum_mean(1.0, 600.0, drift=other).delay.mean > cusum


def test_delay_of_a_two_sided_design_is_that_of_the_side_of_the_shift() -> None:
    two = design_cusum_mean(1.0, 1e4, "both")
    one = CusumMean(0.5, two.detector.level)
    assert two.delay.mean == pytest.approx(one.average_run_length(1.0).mean, rel=1e-3)


def test_run_lengths_without_a_change_are_nearly_exponential() -> None:
    """A long run length's standard deviation is about its mean; so intervals of false alarms are Poisson's."""
    lengths = run_lengths(CusumMean(0.5, 4.0), gaussian(), 4000, seed=3)
    assert lengths.std() == pytest.approx(lengths.mean(), rel=0.06)


@pytest.mark.parametrize(
    ("request_", "complaint"),
    [
        (lambda: design_cusum_mean(1.0, 1e13), "is 1e+13 samples, feasible: 1 to 1e+12"),
        (lambda: design_cusum_mean(1.0, 0.9), "is 0.9 samples, feasible: 1 to 1e+12"),
        (lambda: design_cusum_mean(1.0, np.nan), "is nan samples"),
        (lambda: design_cusum_mean(-1.0, 100.0), "shift is -1, valid: a number above 0"),
        (lambda: design_cusum_mean(1.0, 100.0, "up"), "sides is 'up'"),
        (lambda: design_cusum_variance(1.0, 1.0, 100.0), "variance after is 1"),
        (lambda: design_cusum_variance(0.0, 1.0, 100.0), "variance before is 0"),
        (lambda: design_local_cusum(3.0, 100.0, (1.0,)), "drift is 1.5, valid: below the limit 1"),
        (lambda: design_glr(0.1, 1e5), "shift is 0.1, feasible: at least 0.303"),
        (lambda: samples_between(1e6, 10.0), "feasible at 10 Hz: at most 36000"),
        (lambda: samples_between(1.0, 0.0), "rate is 0"),
        (lambda: simulated_run_length(CusumMean(0.5, 90.0), alarms=9).mean, "too rare to be simulated"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(
    request_: Callable[[], object], complaint: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run_lengths, "__defaults__", (0, 1e5))
    with pytest.raises(ValueError) as refusal:  # noqa: PT011  the text is compared below
        request_()
    assert complaint in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_false_alarms_per_hour() -> None:
    assert samples_between(0.01, 100.0) == pytest.approx(3.6e7)
    assert design_cusum_mean(1.0, 3.6e7).false_alarms_per_hour(100.0) == pytest.approx(0.01, rel=1e-4)

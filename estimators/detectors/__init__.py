"""Change detectors whose false-alarm rate is designed, and that design. Needs numpy, scipy and numba, nothing else
here.

    monitor = Monitor(design_cusum_mean(shift=1.0, arl0=1e4, sides="both").detector)
    reading = monitor.step(residual / its_standard_deviation)      # reading.statistic, reading.alarm

Kinds: `CusumMean`, `CusumVariance`, `Ewma` (GMA), `Glr`, `LocalCusum` (also local + global), `Integrator` (AC, ACF,
ACS). Each knows its average run length; `design_*` finds its parameters, `simulated_run_length` checks them,
`fit_whitener` and `empirical_threshold` are for residuals that are correlated or not Gaussian.
"""

from estimators.detectors.approximations import siegmund_run_length, siegmund_threshold, wald_run_length
from estimators.detectors.cusum import CusumMean, CusumVariance, thesis_theta, variance_drift
from estimators.detectors.design import (
    Design,
    design_cusum_mean,
    design_cusum_variance,
    design_ewma,
    design_glr,
    design_integrator,
    design_local_cusum,
)
from estimators.detectors.detector import SIDES, Detector, RunLength
from estimators.detectors.empirical import EmpiricalThreshold, count_alarms, empirical_threshold, poisson_interval
from estimators.detectors.ewma import Ewma
from estimators.detectors.glr import Glr
from estimators.detectors.integrator import Integrator
from estimators.detectors.local_cusum import LocalCusum
from estimators.detectors.monitor import Monitor, Reading, Readings, missing_samples
from estimators.detectors.simulate import gaussian, interval, run_lengths, simulated_run_length
from estimators.detectors.threshold import samples_between, threshold_for
from estimators.detectors.whitening import Whitener, WhiteningFilter, fit_whitener

__all__ = [
    "SIDES",
    "CusumMean",
    "CusumVariance",
    "Design",
    "Detector",
    "EmpiricalThreshold",
    "Ewma",
    "Glr",
    "Integrator",
    "LocalCusum",
    "Monitor",
    "Reading",
    "Readings",
    "RunLength",
    "Whitener",
    "WhiteningFilter",
    "count_alarms",
    "design_cusum_mean",
    "design_cusum_variance",
    "design_ewma",
    "design_glr",
    "design_integrator",
    "design_local_cusum",
    "empirical_threshold",
    "fit_whitener",
    "gaussian",
    "interval",
    "missing_samples",
    "poisson_interval",
    "run_lengths",
    "samples_between",
    "siegmund_run_length",
    "siegmund_threshold",
    "simulated_run_length",
    "thesis_theta",
    "threshold_for",
    "variance_drift",
    "wald_run_length",
]

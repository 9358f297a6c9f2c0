"""python -m estimators design-cusum: drift and threshold of a CUSUM for a stated false-alarm rate; a table, JSON.

Mean: residuals of unit variance, drift and shift in their standard deviation, delay at a shift of twice the drift
unless --shift says another. Variance: statistic on y^2 / S0 with the drift theta of the two variances, delay with
variance S1. Run lengths are in samples, exact for independent Gaussian residuals; Siegmund's and Wald's approximations
stand beside those of the mean.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from math import isfinite
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from estimators.arguments import Parser
from estimators.detectors import (
    SIDES,
    CusumMean,
    CusumVariance,
    Design,
    design_cusum_mean,
    design_cusum_variance,
    samples_between,
    siegmund_run_length,
    wald_run_length,
)
from estimators.detectors.detector import check_number
from estimators.whole_file import check_writable, write_json

NAME = "design-cusum"


def parser() -> argparse.ArgumentParser:
    """The command line."""
    command = Parser(prog=f"python -m estimators {NAME}", description="Design a CUSUM for a stated false-alarm rate.")
    add = command.add_argument
    add("--drift", type=float, metavar="K", help="drift of a CUSUM for the mean [std] (default: half the shift)")
    add("--shift", type=float, metavar="D", help="shift of the mean to find [std] (default: twice the drift)")
    add("--variance", type=float, nargs=2, metavar=("S0", "S1"), help="a change of the variance instead, from S0 to S1")
    sides = command.add_mutually_exclusive_group()
    sides.add_argument("--two-sided", action="store_const", dest="sides", const="both", help="shifts up and down")
    sides.add_argument("--sides", choices=tuple(SIDES), help="shifts up, down or both (default: upper)")
    add("--arl0", type=float, metavar="N", help="mean samples between false alarms that are asked for")
    add("--rate-hz", type=float, metavar="F", help="samples per second")
    add("--false-alarms-per-hour", type=float, metavar="A", help="instead of --arl0, with --rate-hz")
    add("--json", type=Path, metavar="FILE", help="write the design: threshold, arl0, delay, ...")
    return command


def asked_arl0(options: argparse.Namespace) -> float:
    """Samples between false alarms. ValueError if it is said twice, or not at all."""
    if options.false_alarms_per_hour is None:
        if options.arl0 is None:
            raise ValueError("no false-alarm rate given, want --arl0, or --false-alarms-per-hour and --rate-hz")
        return options.arl0
    if options.arl0 is not None:
        raise ValueError("--arl0 and --false-alarms-per-hour are both given, want one of them")
    if options.rate_hz is None:
        raise ValueError("--false-alarms-per-hour needs --rate-hz, the samples per second")
    return samples_between(options.false_alarms_per_hour, options.rate_hz)


def design(options: argparse.Namespace) -> Design:
    """As asked for. ValueError if it cannot be."""
    arl0 = asked_arl0(options)
    if options.rate_hz is not None:
        samples_between(1e-300, options.rate_hz)  # refuses a rate that is none
    if options.variance is not None:
        for name, value in (("--shift", options.shift), ("--two-sided or --sides", options.sides)):
            if value is not None:
                raise ValueError(f"{name} is for the mean, want it without --variance")
        before, after = options.variance
        return design_cusum_variance(before, after, arl0)
    if options.drift is None and options.shift is None:
        raise ValueError("no change given, want --drift, --shift, or --variance S0 S1")
    if options.drift is not None:
        check_number("--drift", options.drift, 0.0, above=options.shift is None)
    shift = 2.0 * options.drift if options.shift is None else options.shift
    return design_cusum_mean(shift, arl0, options.sides or "upper", options.drift)


def document(found: Design, options: argparse.Namespace) -> dict[str, Any]:
    """The design as JSON values."""
    detector = found.detector
    assert isinstance(detector, CusumMean | CusumVariance)
    result: dict[str, Any] = {
        "threshold": detector.threshold,
        "arl0": found.arl0.mean,
        "delay": found.delay.mean,
        "drift": detector.drift,
        "asked_arl0": asked_arl0(options),
        "method": found.arl0.method,
    }
    if isinstance(detector, CusumMean):
        h, k = detector.threshold, detector.drift
        halves = 2.0 if detector.sides == "both" else 1.0
        result |= {"change": "mean", "sides": detector.sides, "shift": found.change}
        result["siegmund_arl0"] = _finite(siegmund_run_length(h, k) / halves)
        result["wald_arl0"] = _finite(wald_run_length(h, k) / halves)
        result["siegmund_delay"] = siegmund_run_length(h, k, found.change)
        result["wald_delay"] = wald_run_length(h, k, found.change)
    else:
        before, after = options.variance
        result |= {"change": "variance", "sides": detector.change, "variance_before": before, "variance_after": after}
    if options.rate_hz is not None:
        result["rate_hz"] = options.rate_hz
        result["false_alarms_per_hour"] = found.false_alarms_per_hour(options.rate_hz)
        result["delay_s"] = found.delay.mean / options.rate_hz
    return result


def _finite(value: float) -> float | None:
    return value if isfinite(value) else None


def print_design(console: Console, result: dict[str, Any], unused_drift: float | None) -> None:
    """A table of the figures, and what a reader must know of them."""
    console.print(f"CUSUM for a change of the {result['change']}, {result['sides']}; run lengths in samples")
    table = Table("quantity")
    table.add_column("value", justify="right")
    for name, value in result.items():
        if isinstance(value, float):
            table.add_row(name, f"{value:.5g}")
    console.print(table)
    if result["threshold"] == 0.0 and result["arl0"] > result["asked_arl0"]:
        console.print(
            "no threshold is needed: every sample beyond the drift alarms, more rarely than asked", soft_wrap=True
        )
    if unused_drift is not None:
        console.print(
            f"--drift {unused_drift:g} is for the mean; the drift here is theta of the two variances", soft_wrap=True
        )


def run(arguments: Sequence[str], console: Console) -> None:
    """Design, print, write. ValueError or OSError with one line when that is not possible."""
    options = parser().parse_args(arguments)
    if options.json:
        check_writable(options.json)
    found = design(options)
    result = document(found, options)
    print_design(console, result, options.drift if options.variance is not None else None)
    if options.json:
        write_json(options.json, result)

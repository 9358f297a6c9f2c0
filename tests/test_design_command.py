"""Claims about `python -m estimators design-cusum`: its figures, its JSON, and one line for every bad input."""

from __future__ import annotations

import ast
import json
from pathlib import Path

import pytest

import estimators.detectors
from estimators.__main__ import main
from estimators.detectors import CusumMean, CusumVariance


def designed(tmp_path: Path, *options: str) -> dict[str, float]:
    """The JSON of a design."""
    out = tmp_path / "design.json"
    assert main(["design-cusum", *options, "--json", str(out)]) == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["design.json"]
    return json.loads(out.read_text())


def test_a_design_for_the_mean(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = designed(tmp_path, "--drift", "0.5", "--arl0", "1e4")
    detector = CusumMean(0.5, said["threshold"])
    assert said["arl0"] == detector.average_run_length().mean == pytest.approx(1e4, rel=1e-4)
    assert said["delay"] == detector.average_run_length(1.0).mean
    assert (said["drift"], said["shift"], said["sides"]) == (0.5, 1.0, "upper")
    printed = capsys.readouterr().out
    assert f"{said['threshold']:.5g}" in printed
    assert "siegmund_arl0" in printed


def test_drift_is_half_the_shift_unless_both_are_said(tmp_path: Path) -> None:
    assert designed(tmp_path, "--shift", "0.8", "--arl0", "500")["drift"] == 0.4
    both = designed(tmp_path, "--drift", "0.5", "--shift", "2", "--arl0", "500")
    assert both["delay"] == CusumMean(0.5, both["threshold"]).average_run_length(2.0).mean


def test_a_two_sided_design_has_twice_the_one_sided_run_length_at_its_threshold(tmp_path: Path) -> None:
    said = designed(tmp_path, "--drift", "0.5", "--arl0", "465.44", "--two-sided")
    assert said["threshold"] == pytest.approx(5.0, abs=1e-3)
    assert said["sides"] == "both"


def test_a_design_for_the_variance(tmp_path: Path) -> None:
    said = designed(tmp_path, "--variance", "2", "6", "--arl0", "200")
    assert said["threshold"] == pytest.approx(8.15, abs=6e-3)
    assert said["drift"] == pytest.approx(1.6479, abs=1e-4)
    detector = CusumVariance(said["drift"], said["threshold"])
    assert said["delay"] == pytest.approx(detector.average_run_length(std=3.0**0.5).mean)
    assert said["delay"] == pytest.approx(7.9, abs=0.05)


def test_a_drift_beside_a_variance_is_said_to_be_unused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    alone = designed(tmp_path, "--variance", "1", "3", "--arl0", "100")
    assert designed(tmp_path, "--drift", "0.5", "--variance", "1", "3", "--arl0", "100") == alone
    assert "--drift 0.5 is for the mean; the drift here is theta" in capsys.readouterr().out


def test_a_rate_per_hour(tmp_path: Path) -> None:
    said = designed(tmp_path, "--drift", "0.2", "--two-sided", "--rate-hz", "20", "--false-alarms-per-hour", "0.01")
    assert said["threshold"] == pytest.approx(33.7, abs=0.05)
    assert said["asked_arl0"] == pytest.approx(7.2e6)
    assert said["false_alarms_per_hour"] == pytest.approx(0.01, rel=1e-4)
    assert said["delay_s"] == pytest.approx(said["delay"] / 20.0)


def test_where_no_threshold_is_needed_it_is_0_and_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = designed(tmp_path, "--drift", "5", "--arl0", "200")
    assert (said["threshold"], said["arl0"]) == (0.0, pytest.approx(3.4886e6, rel=1e-4))
    assert "no threshold is needed" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ("--arl0 100", "no change given, want --drift, --shift, or --variance S0 S1"),
        ("--drift 0.5", "no false-alarm rate given, want --arl0"),
        ("--drift 0.5 --arl0 1e20", "1e+20 samples, feasible: 1 to 1e+12"),
        ("--variance 1 3 --arl0 3e11", "feasible for this change (what is longer is not resolved): 2.2e+08"),
        ("--variance 1 1.01 --arl0 1e9", "feasible for this change (what is longer is not resolved): "),
        ("--shift 1e300 --arl0 100", "shift is 1e+300, valid: a number above 0 and at most 1e+06"),
        ("--drift 0.5 --arl0 nan", "nan samples, feasible"),
        ("--drift 0.5 --arl0 0.5", "0.5 samples, feasible"),
        ("--drift -1 --arl0 100", "--drift is -1, valid: a number above 0"),
        ("--drift x --arl0 100", "invalid float value: 'x'"),
        ("--shift 0 --arl0 100", "shift is 0, valid: a number above 0"),
        ("--drift 0.5 --arl0 100 --rate-hz -4", "rate is -4"),
        ("--drift 0.5 --arl0 100 --rate-hz 10 --false-alarms-per-hour 1", "both given, want one"),
        ("--drift 0.5 --false-alarms-per-hour 1", "needs --rate-hz"),
        ("--drift 0.5 --false-alarms-per-hour 1e9 --rate-hz 10", "feasible at 10 Hz: at most 36000"),
        ("--variance 1 1 --arl0 100", "variance after is 1"),
        ("--variance 1 -3 --arl0 100", "variance after is -3"),
        ("--variance 1 --arl0 100", "expected 2 arguments"),
        ("--variance 1 3 --shift 1 --arl0 100", "--shift is for the mean"),
        ("--variance 1 3 --two-sided --arl0 100", "--two-sided or --sides is for the mean"),
        ("--drift 0.5 --sides left --arl0 100", "choose from"),
        ("--drift 0.5 --arl0 100 --threshold 3", "--threshold 3"),
        ("--drift 0.5 --arl0 100 --json .", "is a folder, want a file name"),
    ],
)
def test_bad_input_is_one_line_with_status_2(
    options: str, complaint: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["design-cusum", *options.split()]) == 2
    line = capsys.readouterr().err
    assert complaint in line
    assert line.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_the_detectors_stand_alone() -> None:
    """They import numpy, scipy, themselves and the compiler, so that they can be taken elsewhere."""
    allowed = ("numpy", "scipy", "estimators.detectors", "estimators.compiled")
    standard = {"__future__", "abc", "collections.abc", "dataclasses", "functools", "math", "typing"}
    for source in Path(estimators.detectors.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(source.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            for name in names:
                assert name in standard or name.startswith(allowed), f"{source.name} imports {name}"

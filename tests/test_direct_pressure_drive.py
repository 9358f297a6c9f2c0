"""The direct monitor in a drive: a leak is told on its wheel alone, in table, recording and JSON."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from estimators.readers import read_log
from testbed.drive import main


def _driven(folder: Path, *arguments: str) -> tuple[list[dict], list[str], str]:
    """Alarms of the JSON, of the recording, of this estimator, and the JSON's estimates as text."""
    out, result = folder / "drive.rrd", folder / "drive.json"
    words = ["--road", "flat", "--estimators", "direct_pressure", "--out", str(out), "--json", str(result)]
    assert main([*words, *arguments]) == 0
    document = json.loads(result.read_text())
    log = read_log(out)
    recorded = [str(text) for text in log["alarm/direct_pressure"].value] if "alarm/direct_pressure" in log else []
    return document["alarms"], recorded, document["estimates"]


def test_leak_alarms_on_its_wheel_alone_in_table_recording_and_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    alarms, recorded, estimates = _driven(tmp_path, "--leak", "rr=5@20", "--duration", "26")
    assert [alarm["text"] for alarm in alarms] == recorded
    assert recorded
    assert all(text.startswith("rr: leak: ") for text in recorded)
    assert 20.0 < alarms[0]["time_s"] < 24.0
    shown = " ".join(capsys.readouterr().out.split())
    assert recorded[0] in shown
    rate = estimates["est/direct_pressure/rr/leak_rate"]
    assert rate["value"] == pytest.approx(5e3 * 220.0 / 250.0, abs=4.0 * rate["std"])
    pressure = estimates["est/direct_pressure/rr/pressure"]
    assert pressure["value"] == pytest.approx(222e3, abs=4.0 * pressure["std"])


def test_drive_at_nominal_pressures_raises_no_alarm(tmp_path: Path) -> None:
    assert _driven(tmp_path, "--duration", "30", "--seed", "3", "--quiet")[:2] == ([], [])


def test_tyre_far_below_nominal_is_told_low(tmp_path: Path) -> None:
    alarms, _, _ = _driven(tmp_path, "--duration", "8", "--pressure", "fl=150", "--quiet")
    assert len(alarms) == 1
    assert alarms[0]["text"].startswith("fl: low pressure: 1")

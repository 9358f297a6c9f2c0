"""The command that identifies what estimators start from: its names, its refusals, what it writes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from models.identified import CLASS_QUARTER_CARS, QUARTER_CARS, STEERING_MONITORS, STEERING_SERVO, TWO_AXLES
from testbed.identify import __main__ as command


def test_each_name_writes_the_file_that_drives_read() -> None:
    assert {name: place for name, (place, _) in command.KINDS.items()} == {
        "quarter-cars": QUARTER_CARS, "axles": TWO_AXLES, "published": CLASS_QUARTER_CARS,
        "steering-servo": STEERING_SERVO, "steering-monitors": STEERING_MONITORS,
    }  # fmt: skip
    assert all(place.is_file() for place, _ in command.KINDS.values())


def test_the_result_is_written_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(command.KINDS, "axles", (tmp_path / "unused.json", lambda: {"wheelbase": 2.8}))
    assert command.main(["axles", "--out", str(tmp_path / "a.json")]) == 0
    assert json.loads((tmp_path / "a.json").read_text()) == {"wheelbase": 2.8}
    assert [path.name for path in tmp_path.iterdir()] == ["a.json"]


@pytest.mark.parametrize("arguments", [["tyres"], [], ["axles", "--out", "/proc/none/a.json"]])
def test_what_cannot_be_is_one_line(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    try:
        status = command.main(arguments)
    except SystemExit as stopped:
        status = stopped.code
    assert status == 2
    assert capsys.readouterr().err.count("\n") == 1

"""The study `fleet-leaks`: how it reads, judges and counts, and what it finds in the real record if that is there."""

from __future__ import annotations

import json

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from estimators.detectors import CusumMean, empirical_threshold
from estimators.slow_leak.monitor import find_leaks
from estimators.slow_leak.numbers import BETWEEN_FALSE_ALARMS, DAY, MODEL, MONTH
from testbed.study import __main__ as command
from testbed.study.fleet_leaks.fleet import digest, read_fleet
from testbed.study.fleet_leaks.fleet_leaks import DATA, FleetLeaksStudy
from testbed.study.fleet_leaks.trials import innovations, reordered, sound_tyres
from testbed.study.fleet_leaks.verdict import judge
from testbed.study.fleet_leaks.windows import weeks

DAYS, START = 160, 60
KNOWN = {("63918869", "29"), ("64218239", "27")}  # whoever looks at the pictures sees these, and no other


def vehicle(seed: int) -> np.ndarray:
    """Days' values [Pa] of six tyres."""
    rng = np.random.default_rng(seed)
    common = 9e5 + rng.normal(0.0, 4e3, (DAYS, 1)) - 6e3 / 30.0 * np.arange(DAYS)[:, None]
    return common + rng.normal(0.0, 2e3, (DAYS, 6))


def leaky(seed: int, until: int = DAYS) -> np.ndarray:
    """Tyre 2 loses 40 kPa a month from day 60 until another."""
    y = vehicle(seed)
    y[:, 2] -= 40e3 / 30.0 * np.clip(np.arange(DAYS) - START, 0, until - START)
    return y


@pytest.fixture
def file(tmp_path):
    """A fleet record of a vehicle with a leak, one without, and one that sent nothing."""
    hours = np.arange(0, DAYS * 24, 4)
    stamps = [str(np.datetime64("2024-04-01T00:30:00") + np.timedelta64(int(h), "h")) + "Z" for h in hours]
    columns: dict[str, list] = {"mongoID": [], "timestamp": [], **{f"pressure_{n}": [] for n in "abcdef"}}
    rng = np.random.default_rng(0)
    for name, y in (("000000001x", leaky(1)), ("000000002x", vehicle(2)), ("000000003x", np.full((DAYS, 6), np.nan))):
        columns["mongoID"] += [name] * len(hours)
        columns["timestamp"] += stamps
        for tyre, letter in enumerate("abcdef"):
            bar = np.round((y[hours // 24, tyre] + rng.normal(0.0, 2e3, len(hours))) / 1e5, 2)
            columns[f"pressure_{letter}"] += [None if np.isnan(v) else float(v) for v in bar]
    path = tmp_path / "fleet.parquet"
    pq.write_table(pa.table(columns), path)
    return path


def test_record_is_read_in_si_with_the_shortest_names_that_differ(file) -> None:
    fleet = read_fleet(file)
    assert [t.name for t in fleet] == ["000000001", "000000002"]
    assert fleet[0].tyres == tuple("abcdef")
    days, pressure = fleet[0].days()
    assert len(days) == DAYS
    assert np.nanmedian(pressure) == pytest.approx(9e5, rel=0.1)
    assert fleet[0].time[0] == np.datetime64("2024-04-01T00:30:00").astype("datetime64[s]").astype(float)


def test_study_finds_and_judges_the_leak_of_another_file(file, tmp_path, capsys) -> None:
    out, told = tmp_path / "out", tmp_path / "told.json"
    words = ["fleet-leaks", "--data", str(file), "--small", "--runs", "1", "--jobs", "1", "--out", str(out)]
    assert command.main([*words, "--json", str(told)]) == 0
    assert "leak_000000001_c_from_2024-0" in capsys.readouterr().out
    assert (out / "finding-01-000000001-c.png").read_bytes().startswith(b"\x89PNG")
    assert (out / "overview.png").is_file()
    found = {row["name"]: row["here"] for row in json.loads(told.read_text())["rows"]}
    assert (found["findings_all"], found["precision_all"]) == (1.0, 1.0)
    assert found["largest_rate_kpa_month"] == pytest.approx(40.0, rel=0.1)
    assert found["natural_loss_kpa_month"] == pytest.approx(6.0, abs=1.0)


@pytest.mark.parametrize("kind", ["absent", "text", "columns", "empty", "stamps"])
def test_a_bad_file_is_refused_in_one_line(kind, tmp_path, capsys) -> None:
    path = tmp_path / "bad.parquet"
    column = {"mongoID": ["x"], "timestamp": ["yesterday" if kind == "stamps" else "2024-04-01T00:00:00Z"]}
    if kind == "text":
        path.write_text("mongoID,timestamp\n")
    elif kind == "columns":
        pq.write_table(pa.table({"a": [1]}), path)
    elif kind in ("empty", "stamps"):
        pressure = pa.array([None if kind == "empty" else 9.0], pa.float64())
        pq.write_table(pa.table(column | {"pressure_a": pressure}), path)
    words = ["fleet-leaks", "--data", str(path), "--jobs", "1", "--runs", "1", "--out", str(tmp_path / "out")]
    assert command.main(words) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "bad.parquet" in said


def test_data_for_a_study_that_reads_none_is_refused(tmp_path, capsys) -> None:
    assert command.main(["tpms-leak", "--data", "x.parquet", "--out", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "fleet-leaks" in said


def test_a_loss_that_goes_on_is_judged_true_and_one_that_stops_at_the_alarm_false() -> None:
    day = np.arange(DAYS)
    goes_on = leaky(3)
    watched = find_leaks(day, goes_on)
    assert judge(watched, goes_on, watched.leaks[0]).verdict == "true"
    stops = leaky(3, watched.leaks[0].alarm)
    watched = find_leaks(day, stops)
    assert judge(watched, stops, watched.leaks[0]).verdict == "false"


def test_a_filled_tyre_is_judged_true_and_a_fleet_that_is_filled_tells_nothing() -> None:
    for tyres, filled in (([2], True), (range(6), False)):
        y = leaky(4)
        alarm = find_leaks(np.arange(DAYS), y).leaks[0].alarm
        y[alarm + 2 :, list(tyres)] += 1e5
        watched = find_leaks(np.arange(DAYS), y)
        verdict = judge(watched, y, watched.leaks[0])
        assert (verdict.filled is not None) == filled


def test_weeks_with_the_leak_are_those_after_its_start() -> None:
    watched = find_leaks(np.arange(DAYS), leaky(5))
    told = weeks(watched, 2)
    assert sum(leaking for _, leaking, _ in told) == pytest.approx((DAYS - START) / 7.0, abs=2)
    assert all(leaking for _, leaking, alarmed in told if alarmed)
    assert not any(leaking or alarmed for _, leaking, alarmed in weeks(watched, 0))


def test_blocks_in_a_random_order_keep_the_values() -> None:
    white = [np.arange(21.0), 100.0 + np.arange(14.0)]
    x = reordered(white, 3, np.random.default_rng(0))
    assert sorted(x) == sorted(np.tile(np.concatenate(white), 3))
    assert set(np.diff(x.reshape(-1, 7), axis=1).ravel()) == {1.0}


real = pytest.mark.skipif(not DATA.is_file(), reason=f"the fleet record {DATA} is not there")


@real
def test_real_fleet_has_two_leaking_tyres_and_no_other() -> None:
    fleet = read_fleet(DATA)
    assert len(fleet) == 8
    assert sum(len(t.tyres) for t in fleet) == 47
    found = set()
    for trailer in fleet:
        days, pressure = trailer.days()
        watched = find_leaks(days, pressure)
        for leak in watched.leaks:
            found.add((trailer.name, trailer.tyres[leak.tyre]))
            assert judge(watched, pressure, leak).verdict == "true"
            assert leak.whole.rate.low > 30e3 / MONTH
    assert found == KNOWN


@real
def test_threshold_is_what_the_tuning_trailers_ask_for() -> None:
    """0.5: the spread of `empirical_threshold` over orders of the blocks and the figures it is rounded to."""
    tuning = tuple(trailer for trailer in read_fleet(DATA) if trailer.tuning)
    x = reordered(innovations(tuning, sound_tyres(tuning)), 300, np.random.default_rng(0))
    asked = empirical_threshold(x, lambda h: CusumMean(MODEL.drift, h, "lower"), BETWEEN_FALSE_ALARMS)
    assert abs(asked.threshold - MODEL.threshold) < 0.5


@real
def test_file_of_the_study_is_known_by_its_content() -> None:
    assert len(digest(DATA)) == 16
    assert FleetLeaksStudy().tasks(1, 0, True)[0]["digest"] == digest(DATA)
    assert DAY * 30.0 == MONTH

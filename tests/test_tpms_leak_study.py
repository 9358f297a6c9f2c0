"""The figures of the study `tpms-leak`, from made-up rows of which they are known, and its made-up days."""

from __future__ import annotations

import numpy as np
import pytest

from estimators.direct_pressure.monitor import SAID, new_memory
from estimators.direct_pressure.numbers import MODEL
from models.tyre_properties import load_tyre
from testbed.study.tpms_leak.bound import SHIFTS, first_alarms, first_matched, levels
from testbed.study.tpms_leak.paper import PROCESSES, repetitions
from testbed.study.tpms_leak.plant import DAYS, NOMINAL, days, new_state, volume_share
from testbed.study.tpms_leak.tpms_leak import TpmsLeakStudy
from testbed.study.tpms_leak.work import LEAKS, OFF, OFF_HOURS, SENSORS
from testbed.tyre.inflation import ATMOSPHERE


def _row(seed):
    rng = np.random.default_rng(seed)
    paper = {}
    for name in PROCESSES:
        paper |= {f"alarms{name}": 50, f"seconds{name}": 60.0, f"squares{name}": [0.04, 0.04]}
        paper |= {f"with_leak{name}": [1.0, 2.0], f"without_leak{name}": [1.5, 1.5]}
    trials = [
        {
            "early": False, "delay": 12.0, "bound": [20.0, 10.0] + [30.0] * (len(SHIFTS) - 1),
            "rates": [[5.0 + x, 1.0, 5.0], [5.0 + 2.0 * y, 2.0, 5.0]],
        }
        for x, y in rng.normal(0.0, 1.0, (60, 2)).tolist()
    ]  # fmt: skip
    early = [{"early": True, "delay": None, "bound": [1.0] * (len(SHIFTS) + 1), "rates": []}]
    return {
        "paper": paper, "leaks": {n + e: trials + early for n in LEAKS for e in SENSORS},
        "sound": {e: {"alarms": 1, "hours": 100.0, "largest": [0.5, 1.1]} for e in SENSORS},
        "off": {f"{e}_{n}": {"alarms": 2, "hours": 50.0} for e in OFF_HOURS for n in OFF},
    }  # fmt: skip


def test_figures_are_those_of_the_rows() -> None:
    found = {row.name: row for row in TpmsLeakStudy().table([_row(0), _row(1)])}
    assert found["published_false_alarm_interval_s"].here == pytest.approx(60.0 / 50.0)
    assert found["published_false_alarm_interval_s"].limit == pytest.approx(1.12, abs=0.005)
    assert found["published_filter_rmse_psi"].here == pytest.approx(0.2)
    assert found["published_delay_with_leak_s"].here == found["published_delay_without_leak_s"].here == 1.5
    assert found["delay_s_1_psi_s"].here == 12.0
    assert found["delay_s_1_psi_s"].limit == 10.0
    assert found["delay_over_bound"].here == pytest.approx(1.2)
    assert found["leak_rate_rmse_over_reported_std"].here == pytest.approx(1.0, abs=0.15)
    assert (found["false_alarms"].here, found["false_alarms"].limit) == (2.0, 2.0)
    assert found["hours"].here == 200.0
    assert found["share_of_leaks_missed"].here == 0.0
    assert found["matched_over_constant_1_psi_s"].here == 3.0
    assert found["false_alarms_60_s_load_steps_150_kg"].here == 4.0
    assert found["hours_1_s_without_speed"].here == 100.0


def test_published_detector_alarms_after_the_same_time_with_and_without_a_leak() -> None:
    row = repetitions(40, np.random.default_rng(0))
    interval = row["seconds"] / row["alarms"]
    assert interval == pytest.approx(1.12, rel=4.0 / row["alarms"] ** 0.5)
    with_leak, without = np.mean(row["with_leak"]), np.mean(row["without_leak"])
    assert abs(with_leak - without) < 4.0 * 1.12 * (2.0 / 40.0) ** 0.5
    assert np.sqrt(np.mean(row["squares"])) == pytest.approx(0.2127, rel=0.05)


def test_made_up_tyre_keeps_its_gas_warms_by_driving_and_leaks_at_the_rate() -> None:
    sound = days(DAYS, new_state(), np.random.default_rng(5), 4 * 3600.0, 1.0, 0.0, 0.0, 0.0, np.inf)
    amount = (sound[3] + ATMOSPHERE) / sound[2]
    assert np.std(amount) / amount.mean() < 4e-3  # loads and rounding to 1 K
    assert np.ptp(sound[2]) < DAYS.heating * 40.0 + 10.0
    assert np.ptp(sound[3]) > 5e3
    leak = days(DAYS, new_state(), np.random.default_rng(5), 600.0, 1.0, 0.0, 0.0, 100.0, 300.0)
    lost = (leak[3] - sound[3][:600])[-1]
    assert lost == pytest.approx(-100.0 * 300.0 * (1.0 - 0.5 * 300.0 * 100.0 / NOMINAL), rel=0.05)


def test_load_on_a_tyre_takes_as_much_volume_as_the_monitor_and_the_days_expect() -> None:
    """Virtual work of the load on an inflated membrane, in the testbed's own tyre."""
    tyre, of_a_volume_20_percent_less = load_tyre("suv-235-60r18"), 1.0 / 0.8
    for load in (4000.0, 5000.0):  # N, on a front wheel and on a rear one with a passenger
        share = volume_share(tyre, load, 75.0) / 75.0
        assert DAYS.share * 0.99 < share < DAYS.share * of_a_volume_20_percent_less
        whole_axle = volume_share(tyre, load, 200.0) * (NOMINAL + ATMOSPHERE)
        assert 1.4 < whole_axle / MODEL.load_std < 2.0  # 400 kg on the axle is within 2 std of a load change


def test_matched_detector_of_a_sound_tyre_waits_at_least_as_long_as_its_threshold() -> None:
    """Run length of the Shiryaev-Roberts sum in noise of the monitor's own model, at a threshold of 400 samples."""
    rng, waits = np.random.default_rng(4), []
    for _ in range(60):
        time = np.arange(0.0, 4000.0)
        given = time, np.zeros(len(time), dtype=np.int64), NOMINAL + 1000.0 * rng.standard_normal(len(time))
        memory = new_memory()
        memory.levels[:] = np.inf
        wait = first_matched(memory, *given, np.zeros((1, len(SAID))), 100.0, 1.0, 400.0, 100.0)
        waits.append(min(wait, 3900.0))
    assert np.mean(waits) > 400.0 * (1.0 - 3.0 / 60.0**0.5)


def test_bound_finds_a_shift_of_its_own_size_after_the_known_delay() -> None:
    rng = np.random.default_rng(3)
    shift = SHIFTS[14]
    first = [
        first_alarms(rng.standard_normal(3000) - shift * (np.arange(3000) >= 500), np.array(SHIFTS), levels(1.0), 500)
        for _ in range(100)
    ]
    delays = np.mean(first, axis=0)
    assert (np.array(first) >= 0).all(axis=0)[14]
    reached = np.where((np.array(first) >= 0).all(axis=0), delays, np.inf)
    assert abs(int(reached.argmin()) - 14) <= 1

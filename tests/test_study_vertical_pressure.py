"""Study `vertical-pressure`: what it draws is what was asked for, its rows say what fabricated drives hold, its small
form runs, and a filter that is given the road beats one that is given another."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from estimators.car import AXLES, Car
from estimators.drive_log import WHEELS
from estimators.quarter_car.bound import Setting, relative_stiffness_std
from estimators.quarter_car.road_shape import class_spectrum
from testbed.roads.iso8608 import KIND
from testbed.roads.spectrum import octave_means, periodogram
from testbed.scenario import Scenario
from testbed.study.study import StudyRow
from testbed.study.vertical_pressure import changes, errors
from testbed.study.vertical_pressure.limits import linear_quarter
from testbed.study.vertical_pressure.listening import drive, last_said
from testbed.study.vertical_pressure.published import words_of
from testbed.study.vertical_pressure.tasks import EACH, LEVELS, SPEEDS, nearest_class, tasks, wavy_road
from testbed.study.vertical_pressure.told import CAR_FIELDS, HIGHEST, LAW_ERROR, LOWEST, TOLD_ERROR, right, wrong
from testbed.study.vertical_pressure.vertical_pressure import VerticalPressureStudy
from testbed.study.vertical_pressure.waviness import settled, waviness_of
from testbed.study.vertical_pressure.work import FINE, work

ROAD = Path("road.txt")


def test_drives_are_drawn_within_table_4_and_repetitions_do_not_depend_on_how_many() -> None:
    every = [[t for t in tasks(3, number, False, ROAD) if "kind" in t] for number in range(60)]
    levels = [t["spectrum"] for found in every for t in found if t["kind"] == "levels"]
    speeds = [t["scenario"]["speed"] for found in every for t in found if t["kind"] == "classes"]
    pressures = [list(t["scenario"]["pressures"].values()) for found in every for t in found if t["kind"] == "classes"]
    assert LEVELS[0] <= min(levels) < 2.0 * LEVELS[0]
    assert LEVELS[1] >= max(levels) > 0.5 * LEVELS[1]
    assert SPEEDS[0] <= min(speeds) < max(speeds) <= SPEEDS[1]
    assert LOWEST <= np.min(pressures) < np.max(pressures) <= HIGHEST
    assert np.ptp(pressures, axis=1).min() > 0.0  # each tyre its own
    assert {t["scenario"]["road"] for found in every for t in found if t["kind"] == "classes"} == set("ABCD")
    seeds = [t["seed"] for found in every for t in found if t["kind"] != "mass"]
    assert len(set(seeds)) == len(seeds)
    assert [len([t for t in found if t["kind"] == "mass"]) for found in every] == ([3] + [0] * (EACH - 1)) * (
        60 // EACH
    )
    assert VerticalPressureStudy().tasks(2, 3, False)[0] == every[0][0]
    assert [number for number in range(9) if "axle_alarm" in tasks(3, number, False, ROAD)[-1]] == [0, 4, 8]
    assert all(nearest_class(t["spectrum"]) == "ABCD"[i] for found in every for i, t in enumerate(found[2:6]))


def test_wrong_knowledge_is_off_by_as_much_as_was_asked_and_right_is_the_makers() -> None:
    car = Car()
    sound, off = right(car), [wrong(car, seed) for seed in range(50)]
    assert sound.car == car
    for name in CAR_FIELDS:
        ratios = [getattr(o.car, name) / getattr(car, name) for o in off]
        assert 1.0 - TOLD_ERROR <= min(ratios) < 0.95 < 1.05 < max(ratios) <= 1.0 + TOLD_ERROR
    slopes = [o.car.tyre_stiffness_per_pressure / car.tyre_stiffness_per_pressure for o in off]
    assert 1.0 - LAW_ERROR <= min(slopes) < 0.85 < 1.15 < max(slopes) <= 1.0 + LAW_ERROR
    for axle in AXLES:
        own = sound.calibrations["vertical_pressure"][axle]
        ratios = [o.calibrations["vertical_pressure"][axle]["unsprung_mass"] / own["unsprung_mass"] for o in off]
        assert 0.9 <= min(ratios) < 0.95 < 1.05 < max(ratios) <= 1.1
        assert off[0].calibrations["vertical_pressure"][axle]["stiffness_std"] == own["stiffness_std"]
        assert off[0].quarters[axle]["A"].damping != sound.quarters[axle]["A"].damping


@pytest.fixture(scope="module")
def heard():
    pressures = dict(zip(WHEELS, (150e3, 180e3, 200e3, 220e3), strict=True))
    return drive(Scenario(road="B", speed=60.0 / 3.6, duration=6.0, seed=4, pressures=pressures))


def test_the_true_road_is_worth_more_than_a_made_up_one_of_its_class(heard) -> None:
    """Root mean square error of four wheels after 6 s: a fifth at most, and less than half the prior's."""
    rms = {}
    for method in ("imm_ukf_oracle", "imm_ukf_synthetic"):
        words = words_of(method, heard, heard.told[0], 1)
        rms[method] = math.sqrt(np.mean((words.pressure[-20:].mean(axis=0) - heard.pressure[-1]) ** 2))
        assert words.probability.sum(axis=2) == pytest.approx(1.0)
        assert (words.std > 0.0).all()
    assert rms["imm_ukf_oracle"] < 14e3
    assert rms["imm_ukf_synthetic"] > 5.0 * rms["imm_ukf_oracle"]


def test_what_was_heard_is_the_drive_s_own(heard) -> None:
    assert np.isfinite(heard.felt).all()
    assert np.abs(heard.felt.mean(axis=(0, 1))).max() < 0.3  # gravity is taken off, offsets have a std of 0.1 m/s^2
    assert heard.pressure[0] == pytest.approx([150e3, 180e3, 200e3, 220e3], rel=5e-3)
    assert last_said(np.array([1.0, 2.0]), np.array([5.0, 6.0]), [0.5, 1.0, 1.9, 9.0])[1:].tolist() == [5.0, 5.0, 6.0]


def _fabricated(kind: str, number: int, kpa: Any, times: list[float], **more: Any) -> dict[str, Any]:
    task = {"kind": kind, "number": number, "spectrum": 16e-6, "scenario": {"duration": times[-1]}}
    return {
        "task": task | more.pop("task", {}), "time_s": times, "truth": [[200.0] * 4 for _ in times],
        "by": {"right": {"bank": {"kpa": kpa, "std": [[10.0] * 4 for _ in times]}}}, "classes": {},
    } | more  # fmt: skip


def _table(drives: list[dict[str, Any]]) -> dict[str, StudyRow]:
    return {row.name: row for row in (*errors.table(drives), *changes.table(drives))}


def test_rows_are_those_of_the_drives() -> None:
    rng = np.random.default_rng(0)
    times, found = [2.0, 10.0], []
    for number in range(400):
        spectrum = 1e-6 * 4.0 ** (number % 4)
        shift = 4.0 if number % 4 == 2 else 0.0
        kpa = (200.0 + shift + 10.0 * rng.standard_normal((2, 4))).tolist()
        bound = [[20.0] * 4, [8.0] * 4]
        found.append(_fabricated("classes", number, kpa, times, task={"spectrum": spectrum}, bound=bound))
    table = _table(found)
    expected = math.sqrt(100.0 + 4.0)
    assert table["bank.rmse_kpa_10s"].here == pytest.approx(expected, rel=0.04)
    assert table["bank.rmse_kpa_10s"].limit == pytest.approx(8.0)
    assert table["bank.nees_10s"].here == pytest.approx(1.04, rel=0.08)
    assert table["bank.bias_kpa_10s"].here == pytest.approx(4.0, abs=1.5)
    assert table["bank.bias_kpa_10s"].here == table["bank.bias_kpa_10s_class_C"].here
    assert abs(table["bank.bias_kpa_10s_class_A"].here or 9.0) < 1.5
    assert table["bank.rmse_over_bound_10s"].here == pytest.approx(expected / 8.0, rel=0.04)
    assert "bank.rmse_kpa_60s" not in table
    assert "axles.rmse_kpa_10s" not in table


def test_delays_are_those_of_the_courses() -> None:
    times = [round(FINE * k, 6) for k in range(1, 201)]
    fall = [[230.0 - (40.0 if t > 12.0 else 0.0)] * 4 for t in times]
    sets = {"pressure_sets": {w: {"start": 10.0} for w in WHEELS}, "duration": 20.0}
    probability = [0.9 if t > 7.0 else 0.0 for t in times]
    shifts = {"0": 200.0, "8": 202.0, "24": 206.0}
    drives = [
        _fabricated("drop", 0, fall, times, task={"scenario": sets}),
        _fabricated("switch", 0, fall, times, classes={"bank": probability}),
        *(_fabricated("mass", n, [[kpa] * 4], [30.0], task={"percent": percent})
          for n in (0, 5) for percent, kpa in shifts.items()),
    ]  # fmt: skip
    table = _table(drives)
    assert table["bank.drop_follow_s"].here == pytest.approx(2.1, abs=1e-6)
    assert table["bank.mode_switch_delay_s"].here == pytest.approx(2.3, abs=0.11)  # half a second's mean passes a half
    assert table["bank.mass_24pct_shift_pct"].here == pytest.approx(3.0)
    assert table["bank.mass_8pct_shift_pct"].here == pytest.approx(1.0)


def test_a_road_steeper_than_believed_reads_as_a_softer_tyre_and_a_believed_one_as_it_is() -> None:
    """A tenth of waviness is 5 % of stiffness. Not knowing it costs information."""
    place = math.log(226e3), math.log(4e-6)
    assert settled(*place, 2.0) == pytest.approx(place[0], abs=1e-3)
    assert settled(*place, 1.9) - place[0] > 0.04
    assert settled(*place, 2.1) - place[0] < -0.04
    bound = Setting(linear_quarter("front"), 226e3, 4e-6, 60.0 / 3.6)
    assert relative_stiffness_std(bound, 10.0, waviness_std=math.inf) > 1.3 * relative_stiffness_std(bound, 10.0)


def test_wavy_road_falls_as_told_and_is_class_b_where_level_and_slope_part() -> None:
    """Mean spectrum of eight tracks of an isotropic surface, by octaves from 0.08 to 2.6 cycle/m."""
    for waviness in (1.8, 3.0):
        road = KIND.build(wavy_road(waviness), 3, 1600.0)
        tracks = road.heights(0.05 * np.arange(32000), np.arange(0.0, 32.0, 4.0))
        spectra = [periodogram(z, 0.05) for z in tracks]
        low, level = octave_means(spectra[0][0], np.mean([power for _, power in spectra], axis=0), 0.08, 2.56)
        n = np.array(
            [
                np.mean(o[(o >= a) & (o < 2.0 * a)] ** -waviness) ** (-1.0 / waviness)
                for a in low
                for o in [spectra[0][0]]
            ]
        )
        slope, at = np.polyfit(np.log(n * 2.0 * math.pi / 4.0), np.log(level), 1)
        assert -slope == pytest.approx(waviness, abs=0.05)
        assert at == pytest.approx(math.log(class_spectrum("B") / 16.0 * 2.0 * math.pi), abs=0.1)
    for text in ("gd=1e-5^9", "gd=1e-5^", "A:20,gd=1e-5^2.5"):
        with pytest.raises(ValueError, match="waviness must be 1 to 4"):
            KIND.build(text, 0, 100.0)


def test_waviness_of_a_profile_is_the_one_it_was_made_with(tmp_path: Path) -> None:
    rng, spacing, n = np.random.default_rng(2), 0.25, 1 << 14
    wave = np.fft.rfftfreq(n, spacing)
    noise = rng.standard_normal(len(wave)) + 1j * rng.standard_normal(len(wave))
    z = np.fft.irfft(noise * np.where(wave > 0.01, np.maximum(wave, 0.01) ** -1.25, 0.0), n)
    file = tmp_path / "road.txt"
    file.write_text("".join(f"{spacing * k} {0.01 * v}\n" for k, v in enumerate(z)))
    assert waviness_of(str(file)) == pytest.approx(2.5, abs=0.15)


@pytest.fixture(scope="module")
def rows():
    small = tasks(7, 0, True, None)
    wanted = {t["kind"]: t for t in small if t.get("kind") in ("classes", "switch", "fit")}
    return [work(task) for task in wanted.values()]


def test_small_form_runs_to_a_table_and_figures(rows) -> None:
    study = VerticalPressureStudy()
    table = {row.name: row for row in study.table(rows)}
    for method in ("single_ukf", "imm_ukf_oracle", "imm_ukf_synthetic", "imm_ukf_state", "bank"):
        assert math.isfinite(table[f"{method}.rmse_kpa_10s"].here)
        assert table[f"{method}.nees_10s"].here > 0.0
        assert 10.0 < table[f"{method}.rmse_kpa_10s"].limit < 20.0
    assert table["bank.rmse_kpa_10s"].here < 40.0
    assert 18.0 < table["bound.rmse_kpa_2s"].here < 28.9  # less than the prior
    assert table["table3.front_A_c_s"].paper == 6576.0
    assert 2000.0 < table["table3.front_A_c_s"].here < 4000.0  # the car's damper: 2.4 and 3.6 kN s/m
    assert {"figure-5-fit", "figure-9-a-to-d"} == set(study.figures(rows))
    assert "figure-6-errors" in study.figures([*rows, *rows])
    assert json.loads(rows[0]["found"])["truth"][0] == pytest.approx(
        [1e-3 * p for p in json.loads(rows[0]["task"])["scenario"]["pressures"].values()], rel=0.01
    )

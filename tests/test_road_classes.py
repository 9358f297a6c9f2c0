"""The car does on the road classes what it did before; a change by 3 % of tyre, damper or road does not go unseen."""

from __future__ import annotations

import copy

import numpy as np
import pytest

from testbed.study.road_classes import expectations
from testbed.study.road_classes.cells import FULL, SMALL, SPEEDS, THREE_PERCENT, Cell, task, tasks
from testbed.study.road_classes.expectations import FALSE_ALARM, learn_paired, learn_unpaired, load, paired, unpaired
from testbed.study.road_classes.learn import gate_seeds
from testbed.study.road_classes.linearised import frequencies
from testbed.study.road_classes.measure import measure
from testbed.study.road_classes.quantities import QUANTITIES
from testbed.study.road_classes.road_classes import RoadClasses

PROBE = Cell("C", 80.0, 250.0)
# what each change must show in, beside whatever else it moves
SHOWS_IN = {"tyre stiffness": "load_variation/front", "damper": "ride", "road level": "load_variation/rear"}


@pytest.fixture(scope="module")
def gate():
    """Rows of the small form, classes A to D, on the roads that were learnt on."""
    return [measure(t) for t in tasks(SMALL, gate_seeds())]


def test_the_car_does_on_classes_a_to_d_what_was_learnt(gate, claim):
    """False alarms: below FALSE_ALARM a run. After a change that is meant: python -m
    testbed.study.road_classes.learn, and say what moved."""
    found = paired(gate, load()["paired"])
    assert len(found) > 100
    off = [str(d) for d in found if d.exceeds]
    assert not off, "\n".join(off)
    claim("road classes A to D against what was learnt", max(abs(d.t) / d.limit for d in found), 1.0, "of the limit")


@pytest.mark.parametrize("change", THREE_PERCENT)
def test_a_change_by_three_percent_is_noticed(change):
    row = measure(task(PROBE, gate_seeds()[0], THREE_PERCENT[change]))
    found = {d.what.partition(", ")[2]: d for d in paired([row], load()["paired"])}
    assert found[SHOWS_IN[change]].exceeds
    assert abs(found[SHOWS_IN[change]].t) > 3.0 * found[SHOWS_IN[change]].limit


def test_a_quantity_that_vanishes_is_noticed(gate):
    row = gate[0] | {"ride": None}
    assert [d.what for d in paired([row], load()["paired"]) if d.exceeds] == [f"{row['cell']}, ride"]


def test_frequencies_of_a_slow_drive_are_those_of_the_linearised_car(gate, claim):
    """Found from spectra of a drive on a rough road, with no knowledge of the road: within some per cent."""
    rows = [row for row in gate if row["cell"] == "D 30 km/h 250 kPa"]
    known = frequencies(30.0, 250.0)
    for quantity in ("hop/front", "hop/rear", "in_phase/front", "in_phase/rear"):
        error = abs(np.mean([row[quantity] for row in rows]) / known[quantity] - 1.0)
        claim("hop and in-phase rotation from a drive's spectra, class D at 30 km/h", 100.0 * error, 10.0, "%")


def test_the_spectrum_of_a_fast_drive_does_not_claim_the_damped_rotation(gate):
    assert all(row["in_phase/front"] is None for row in gate if row["cell"] == "A 120 km/h 250 kPa")


def test_study_covers_every_class_several_speeds_and_three_pressures():
    assert list(SPEEDS) == list("ABCDEFGH")
    assert {cell.pressure for cell in FULL} == {250.0, 200.0, 150.0}
    assert {cell.road for cell in SMALL} == set("ABCD")
    learnt = load()["unpaired"]["cells"]
    for road in "ABCDEFG":
        assert any(cell.name in learnt for cell in FULL if cell.road == road), road


def _drives(rng, cells, seeds, shift=0.0):
    """Rows of made-up drives: what a cell gives, what a seed's road adds to all cells, what is left."""
    rows = []
    for seed in seeds:
        road = rng.normal(0.0, 0.03)
        for i, cell in enumerate(cells):
            level = (1.0 + i) * (1.0 + road + shift + rng.normal(0.0, 0.02))
            rows.append({"cell": cell, "seed": seed, "driven": 1, **dict.fromkeys(QUANTITIES), "ride": level})
    return rows


def _alarm(rng, false_alarm, monkeypatch, shift):
    monkeypatch.setattr(expectations, "FALSE_ALARM", false_alarm)
    cells = [f"cell {i}" for i in range(6)]
    learnt = learn_unpaired(_drives(rng, cells, range(10)))
    return any(d.exceeds for d in unpaired(_drives(rng, cells, range(100, 104), shift), learnt))


def test_unpaired_check_alarms_as_rarely_as_it_says(monkeypatch):
    rng, trials, wanted = np.random.default_rng(0), 400, 0.1
    alarms = sum(_alarm(rng, wanted, monkeypatch, 0.0) for _ in range(trials))
    assert alarms <= wanted * trials + 3.0 * np.sqrt(wanted * trials)  # Bonferroni: at most, not exactly
    assert alarms > 0.2 * wanted * trials


def test_unpaired_check_sees_a_change_that_all_cells_share(monkeypatch):
    rng = np.random.default_rng(1)
    assert all(_alarm(rng, FALSE_ALARM, monkeypatch, 0.5) for _ in range(20))


def test_paired_check_alarms_as_rarely_as_it_says(monkeypatch):
    monkeypatch.setattr(expectations, "FALSE_ALARM", 0.1)
    rng, alarms, trials = np.random.default_rng(2), 0, 400
    plain = _drives(rng, ["a", "b", "c"], (1, 2))

    def moved():
        rows = copy.deepcopy(plain)
        for row in rows:
            row["ride"] *= 1.0 + rng.normal(0.0, 1e-3)
        return rows

    for _ in range(trials):
        learnt = learn_paired(plain, moved() + moved() + moved() + moved())
        alarms += any(d.exceeds for d in paired(moved(), learnt))
    assert 0.2 * 0.1 * trials < alarms <= 0.1 * trials + 3.0 * np.sqrt(0.1 * trials)


def test_a_figure_may_always_move_by_the_numeric_floor():
    rows = _drives(np.random.default_rng(3), ["a"], (1,))
    learnt = learn_paired(rows, 8 * rows)
    assert not any(d.exceeds for d in paired([row | {"ride": row["ride"] * (1.0 + 1e-5)} for row in rows], learnt))
    assert any(d.exceeds for d in paired([row | {"ride": row["ride"] * 1.01} for row in rows], learnt))


def test_a_car_that_tips_over_where_it_should_not_is_an_objection():
    fell = [{"cell": "C 80 km/h 250 kPa", "seed": 7, "driven": 0}, {"cell": "H 5 km/h 250 kPa", "seed": 7, "driven": 0}]
    (line,) = RoadClasses().objections(fell)
    assert line == "C 80 km/h 250 kPa, seed 7: the car fell over or was stuck"

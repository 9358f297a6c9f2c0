"""The contract of every study found, and what the command does with them: table, JSON, reuse, bad input."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from rich.console import Console

from estimators.scores.interval import mean_interval
from testbed.campaign.pool import Pool
from testbed.study import __main__ as command
from testbed.study.registry import studies
from testbed.study.runner import run_study
from testbed.study.study import Study, StudyRow, run_seed
from testbed.study.table import print_table, shown

ROW_KEYS = {"name", "unit", "paper", "here", "ci95", "limit"}
ALL = list(studies().values())


def draw(task):
    """A study without a car: a number from a normal distribution of mean 3."""
    if task["number"] == task.get("fails_at"):
        raise RuntimeError("no luck\nat all")
    return {"x": float(np.random.default_rng(task["seed"]).normal(3.0, 1.0))}


class Toy(Study):
    name = "toy"
    about = "Is the mean 3?"
    paper = "None."
    runs = 4
    fails_at: int | None = None

    @property
    def work(self):
        return draw

    def tasks(self, runs, seed, small):
        return [{"number": n, "seed": run_seed(seed, n), "fails_at": self.fails_at} for n in range(runs)]

    def table(self, rows):
        return [StudyRow.of("mean", "-", mean_interval([row["x"] for row in rows]), paper=3.0)]


def _finite_or_null(value):
    return value is None or math.isfinite(value)


def check_schema(document, name, runs):
    assert set(document) == {"study", "runs", "rows"}
    assert (document["study"], document["runs"]) == (name, runs)
    assert document["rows"]
    for row in document["rows"]:
        assert set(row) == ROW_KEYS
        assert row["name"]
        assert row["unit"]
        assert all(_finite_or_null(row[key]) for key in ("paper", "here", "limit"))
        if row["ci95"] is not None:
            low, high = row["ci95"]
            assert _finite_or_null(low)
            assert _finite_or_null(high)
            assert low is None or row["here"] is None or low <= row["here"]
            assert high is None or row["here"] is None or row["here"] <= high
    names = [row["name"] for row in document["rows"]]
    assert len(names) == len(set(names))


def skip_without_data(study):
    if study.data is not None and not study.data.is_file():
        pytest.skip(f"{study.name}: {study.data} is not there")


@pytest.fixture(scope="module", params=ALL, ids=[study.name for study in ALL])
def told(request, tmp_path_factory):
    """A study, its small form as the command tells it the first and the second time, and the folder."""
    skip_without_data(request.param)
    folder = tmp_path_factory.mktemp(request.param.name)
    tellings = []
    for _ in range(2):
        outcome = run_study(request.param, 1, 0, True, folder, Pool(jobs=1))
        tellings.append(outcome)
    return request.param, tellings, folder


def test_study_declares_what_the_list_shows(told):
    study = told[0]
    assert study.name == study.name.lower()
    assert study.about.endswith("?")
    assert study.paper
    assert study.runs >= 1
    assert "\n" not in study.about + study.paper


def test_study_gives_its_json_form(told):
    study, (first, _), _ = told
    check_schema(json.loads(json.dumps(first.as_json(), allow_nan=False)), study.name, 1)


def test_study_draws_figures_that_are_pictures(told):
    _, (first, _), folder = told
    for file in first.figures:
        assert file.parent == folder
        assert file.read_bytes().startswith(b"\x89PNG")
    for file in first.pages:
        assert file.parent == folder
        assert file.read_text().startswith("<!DOCTYPE html>")


def test_study_reuses_every_finished_task_and_says_the_same(told):
    _, (first, second), _ = told
    assert (first.reused, first.failed) == (0, 0)
    assert second.reused == first.tasks > 0
    assert second.as_json() == first.as_json()


@pytest.mark.parametrize("study", ALL, ids=[study.name for study in ALL])
@pytest.mark.parametrize("small", [False, True])
def test_more_runs_of_a_study_begin_with_the_same_tasks(study, small):
    skip_without_data(study)
    one, three = study.tasks(1, 0, small), study.tasks(3, 0, small)
    assert three[: len(one)] == one
    assert json.loads(json.dumps(three, allow_nan=False)) == three
    keys = {json.dumps(task, sort_keys=True) for task in three}
    assert len(keys) == len(three)
    assert study.tasks(1, 1, small) != one


@pytest.fixture
def toy(monkeypatch):
    study = Toy()
    monkeypatch.setattr(command, "find_study", lambda name: study)
    return study


def _told(capsys, *arguments):
    status = command.main(list(arguments))
    return status, capsys.readouterr()


def test_command_writes_json_and_reuses_what_is_finished(toy, tmp_path, capsys):
    file, out = tmp_path / "toy.json", str(tmp_path / "out")
    status, said = _told(capsys, "toy", "--runs", "3", "--out", out, "--json", str(file), "--jobs", "1")
    assert status == 0
    assert "3 tasks (0 reused, 0 failed)" in said.out
    check_schema(json.loads(file.read_text()), "toy", 3)
    _, said = _told(capsys, "toy", "--runs", "12", "--out", out, "--json", str(file), "--jobs", "1")
    assert "12 tasks (3 reused, 0 failed)" in said.out


def test_more_runs_narrow_the_interval(toy, tmp_path):
    few, many = (run_study(toy, runs, 0, False, tmp_path, Pool(jobs=1)).table[0] for runs in (5, 80))
    assert many.ci95[1] - many.ci95[0] < 0.5 * (few.ci95[1] - few.ci95[0])
    assert many.ci95[0] < 3.0 < many.ci95[1]


def test_a_task_that_fails_is_told_in_one_line_and_the_others_count(toy, tmp_path, capsys):
    toy.fails_at = 1
    status, said = _told(capsys, "toy", "--runs", "4", "--out", str(tmp_path), "--jobs", "1")
    assert status == 0
    assert "4 tasks (0 reused, 1 failed)" in said.out
    assert "failed RuntimeError: no luck at all" in said.out


def test_a_study_of_which_nothing_could_be_done_ends_with_status_2(toy, tmp_path, capsys):
    toy.fails_at = 0
    status, said = _told(capsys, "toy", "--runs", "1", "--out", str(tmp_path), "--jobs", "1")
    assert status == 2
    assert "RuntimeError: no luck at all" in said.err


def test_objections_are_lines_on_stderr_and_status_1(toy, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(Toy, "objections", lambda self, rows: ["the mean is off"])
    status, said = _told(capsys, "toy", "--out", str(tmp_path), "--jobs", "1")
    assert status == 1
    assert said.err == "testbed.study: the mean is off\n"


def test_list_names_every_study(capsys):
    status, said = _told(capsys, "--list")
    assert status == 0
    for study in ALL:
        assert study.name in said.out
        assert f"({study.runs} runs)" in said.out


@pytest.mark.parametrize("runs", ["0", "-1", "nan", "2.5", "", "1e9"])
def test_bad_runs_are_refused_in_one_line(runs, tmp_path, capsys):
    with pytest.raises(SystemExit) as left:
        command.main(["road-classes", "--runs", runs, "--out", str(tmp_path / "out")])
    assert left.value.code == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "--runs" in said
    assert "want a whole number from 1" in said
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("option", [("--seed", "-1"), ("--seed", "x"), ("--jobs", "0"), ("--colour", "red")])
def test_other_bad_options_are_refused_in_one_line(option, capsys):
    with pytest.raises(SystemExit) as left:
        command.main(["road-classes", *option])
    assert left.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("arguments", [[], ["no-such-study"]])
def test_an_unknown_study_lists_the_valid_ones(arguments, capsys):
    status, said = _told(capsys, *arguments)
    assert status == 2
    assert said.err.count("\n") == 1
    assert all(study.name in said.err for study in ALL)


@pytest.mark.parametrize(("option", "place"), [("--json", "file/below"), ("--out", "file/below")])
def test_what_cannot_be_written_is_told_before_anything_runs(option, place, toy, tmp_path, capsys):
    (tmp_path / "file").write_text("here first")
    target = tmp_path / place
    extra = [] if option == "--out" else ["--out", str(tmp_path / "out")]
    status, said = _told(capsys, "toy", option, str(target), *extra)
    assert status == 2
    assert said.err.count("\n") == 1
    assert place.split("/")[0] in said.err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file"]


def test_json_that_is_a_folder_is_refused(toy, tmp_path, capsys):
    status, said = _told(capsys, "toy", "--json", str(tmp_path))
    assert status == 2
    assert "is a folder" in said.err


def test_table_has_the_five_columns_and_shows_intervals_in_deserved_digits(capsys):
    rows = [
        StudyRow("mass", "kg", 2.0, 1.23456, (1.2, 1.3), 5.0),
        StudyRow("radius", "mm", None, 360.67712, (360.6762, 360.6781)),
        StudyRow("nothing yet", "-"),
        StudyRow("time", "s", 60.0, math.inf, (44.0, math.inf)),
    ]
    print_table(Console(width=120), "toy", rows)
    out = capsys.readouterr().out
    assert all(word in out for word in ("quantity", "paper", "here [95 % interval]", "limit", "unit"))
    wanted = ["1.23 [1.20, 1.30]", "360.677 [360.676, 360.678]", "-", "not reached [44, -]"]
    assert [shown(row) for row in rows] == wanted


def test_json_of_a_figure_without_bounds_is_null():
    row = StudyRow("time", "s", None, math.inf, (44.0, math.inf), math.nan).as_json()
    assert row == {"name": "time", "unit": "s", "paper": None, "here": None, "ci95": [44.0, None], "limit": None}
    assert StudyRow("x", "-", None, 1.0, (-math.inf, math.inf)).as_json()["ci95"] is None

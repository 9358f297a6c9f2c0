"""What the README shows is run: its commands, its options, its list of manoeuvres, its figures."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from estimators.__main__ import main as estimate
from estimators.design_cusum import parser as design_parser
from estimators.detectors import Detector
from estimators.faults import fault_kinds, known_targets
from testbed.arguments import drive_parser
from testbed.campaign.__main__ import main as campaign
from testbed.campaign.arguments import campaign_parser
from testbed.campaign.distributions import KINDS
from testbed.campaign.fields import FIELDS
from testbed.campaign.plan import KEYS
from testbed.drive import main as drive
from testbed.manoeuvres.manoeuvre import manoeuvres
from testbed.study.__main__ import main as study
from testbed.study.registry import studies

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text()
COMMANDS = re.findall(r"^\$ (.+)$", README, re.MULTILINE)
DRIVES = [c for c in COMMANDS if c.startswith("python -m testbed.drive")]
CAMPAIGNS = [c for c in COMMANDS if c.startswith("python -m testbed.campaign")]
STUDIES = [c for c in COMMANDS if c.startswith("python -m testbed.study")]
LOGS = [c for c in COMMANDS if c.startswith("python -m estimators") and " design-cusum " not in c]
DESIGNS = [c for c in COMMANDS if c.startswith("python -m estimators design-cusum ")]


def section(heading: str) -> str:
    """What stands under a heading, up to the next one of its level."""
    return README[README.index(heading) :].split("\n## ", 1)[0]


def _options_in(text: str) -> set[str]:
    return set(re.findall(r"`(--[a-z-]+)`", text))


def test_readme_names_every_option_of_a_drive_and_no_other():
    table = section("## Options of a drive")
    actions = drive_parser()._actions
    known = {name for action in actions for name in action.option_strings if name not in ("-h", "--help")}
    assert _options_in(table) == known


def test_readme_lists_every_manoeuvre():
    line = next(row for row in README.splitlines() if row.startswith("| `--manoeuvre`"))
    assert set(re.findall(r"`([a-z-]+)`", line)) - {"--manoeuvre"} == set(manoeuvres())


def test_readme_shows_the_two_commands_that_the_makefile_has():
    targets = re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert {"make drive ROAD=C", "make test"} <= set(COMMANDS)
    assert {"drive", "test"} <= set(targets)


@pytest.mark.parametrize("command", DRIVES)
def test_readme_drive_runs(command, tmp_path, monkeypatch):
    """As typed, but two seconds of it, in a folder of its own; a drive that learns for another one is driven whole."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "recordings").mkdir()
    words = shlex.split(command)[3:]
    if "--calibration" in words:
        learnt = words[words.index("--calibration") + 1]
        before = next(c for c in DRIVES if f"--json {learnt}" in c)
        assert drive([*shlex.split(before)[3:], "--quiet"]) == 0
    assert drive([*words, "--duration", "2", "--quiet"]) == 0
    assert list((tmp_path / "recordings").glob("*.rrd"))


@pytest.mark.parametrize("command", LOGS)
def test_readme_estimators_run(command, tmp_path, monkeypatch, capsys):
    words = shlex.split(command)[3:]
    if words[0].startswith("../shared") and not (ROOT / words[0]).exists():
        pytest.skip(f"{words[0]} is not there")
    if words[0].startswith("recordings/"):
        words[0] = str(tmp_path / "log.rrd")
        assert drive(["--road", "C", "--duration", "3", "--quiet", "--out", words[0]]) == 0
    else:
        monkeypatch.chdir(ROOT)
    assert estimate(words) == 0
    assert "wheel_radius" in capsys.readouterr().out


def test_readme_shows_the_example_campaign_as_it_is():
    for example in (ROOT / "testbed" / "campaign" / "examples").iterdir():
        assert f"```toml\n{example.read_text().rstrip()}\n```" in README


def test_readme_names_every_field_and_distribution_of_a_campaign_and_no_other():
    part = section("## Many drives")
    table = "\n".join(row for row in part.splitlines() if row.startswith("|"))
    assert set(re.findall(r"`\[?([a-z_]+)\]?`", table)) == {*FIELDS, *KEYS}
    assert set(re.findall(r"`\{ ([a-z_]+) = ", table)) - {"rate", "to"} == set(KINDS)


@pytest.mark.parametrize("command", CAMPAIGNS)
def test_readme_campaign_runs(command, tmp_path, monkeypatch, capsys):
    """As typed, but one drive of it and two seconds of that, in a folder of its own."""
    file, *words = shlex.split(command)[3:]
    monkeypatch.chdir(tmp_path)
    short = re.sub(r"(sweep = \[[^,\]]+)[^\]]*", r"\1", (ROOT / file).read_text())
    short = re.sub(r"runs = \d+", "runs = 1", re.sub(r"duration_s = \d+", "duration_s = 2", short))
    (tmp_path / Path(file).name).write_text(short)
    assert campaign([Path(file).name, *words]) == 0
    out = tmp_path / "recordings" / Path(file).stem
    if "--dry-run" in words:
        assert "1 drives" in capsys.readouterr().out
    else:
        assert list(out.glob("drive-0.rrd"))
        assert (out / "report.html").is_file() or "--replay" in words


def test_options_of_a_campaign_in_the_readme_exist():
    part = section("## Many drives")
    known = {name for action in campaign_parser()._actions for name in action.option_strings}
    assert {"--jobs", "--backend"} <= known
    assert _options_in(part) <= known


@pytest.mark.parametrize("command", DESIGNS)
def test_readme_design_prints_what_is_shown(command, capsys):
    assert estimate(shlex.split(command)[3:]) == 0
    printed = capsys.readouterr().out
    assert f"$ {command}\n{printed}" in README


def test_readme_lists_every_kind_of_detector_and_the_options_of_its_design():
    part = section("## Detectors")
    rows = re.findall(r"^\| `(\w+)`", part, re.MULTILINE)
    assert set(rows) == {kind.__name__ for kind in Detector.__subclasses__()}
    known = {name for action in design_parser()._actions for name in action.option_strings}
    assert set(re.findall(r"--[a-z][a-z0-9-]+", part)) <= known


@pytest.mark.parametrize("command", STUDIES)
def test_readme_study_runs(command, tmp_path, monkeypatch, capsys):
    """As typed, but one run of its small form, in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "recordings").mkdir()
    words = shlex.split(command)[3:]
    assert study([*words, "--runs", "1", "--small", "--jobs", "1"]) == 0
    written = [tmp_path / words[i + 1] for i, word in enumerate(words) if word == "--json"]
    assert all(file.is_file() for file in written)
    assert capsys.readouterr().out


def test_readme_shows_every_study():
    table = section("## Studies")
    assert set(re.findall(r"^\| `([a-z-]+)`", table, re.MULTILINE)) == set(studies())


def test_readme_lists_every_kind_of_fault_with_its_numbers_and_every_sensor():
    part = section("## Faults of sensors")
    rows = re.findall(r"^\| `([a-z]+)` \| (.*?) \|", part, re.MULTILINE)
    shown = {kind: re.findall(r"`([A-Z]+)`", numbers) for kind, numbers in rows}
    assert shown == {name: [number.name for number in kind.numbers] for name, kind in fault_kinds().items()}
    sensors = part[part.index("| sensor | unit") :].replace("\\|", "|")
    assert set(re.findall(r"`((?:imu|body|hub|steering|engine|driveline|wheel|tyre)/[^`]+)`", sensors)) >= set(
        known_targets()
    )


def test_files_that_the_readme_names_exist():
    for name in re.findall(r"`((?:testbed|models|estimators|tests)/[\w/.]*)`", README):
        assert (ROOT / name).exists(), name
    for name in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", README):
        assert (ROOT / name).exists(), name


def test_nothing_in_the_readme_waits_to_be_filled_in():
    assert not re.findall(r"\b[A-Z]+_(?:TABLE|FIGURES?)\b", README)


def test_claims_of_the_readme_are_those_that_tests_make():
    table = section("## What is proved")
    shown = set(re.findall(r"^\| (.+?) \| .+ \| .+ \|$", table, re.MULTILINE)) - {"claim"}
    made = "".join(path.read_text() for path in (ROOT / "tests").glob("test_*.py"))
    assert len(shown) > 20
    assert [claim for claim in shown if f'"{claim}"' not in made] == []

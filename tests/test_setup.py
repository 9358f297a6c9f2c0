"""Set-up on a fresh machine: exact versions, one test command, and kernels that are all compiled beforehand."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from importlib.metadata import requires
from pathlib import Path

import numba
import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import estimators.compiled  # noqa: F401  names the cache folder

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def pinned() -> dict[str, str]:
    """Version of each distribution in constraints.txt, by its canonical name."""
    lines = (ROOT / "constraints.txt").read_text().split()
    return {canonicalize_name(name): version for name, version in (line.split("==") for line in lines)}


def test_constraints_are_exact_versions_and_nothing_else() -> None:
    for line in (ROOT / "constraints.txt").read_text().splitlines():
        assert re.fullmatch(r"[A-Za-z0-9._-]+==[0-9][A-Za-z0-9.+]*", line), line


def test_every_dependency_and_what_it_needs_is_pinned_within_its_range(pinned: dict[str, str]) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    waiting = [Requirement(text) for text in (*project["dependencies"], *project["optional-dependencies"]["dev"])]
    seen: set[str] = set()
    while waiting:
        wanted = waiting.pop()
        name = canonicalize_name(wanted.name)
        if wanted.marker and not any(wanted.marker.evaluate({"extra": extra}) for extra in ("", *wanted.extras)):
            continue
        assert name in pinned, f"{name} is in no line of constraints.txt"
        assert wanted.specifier.contains(pinned[name], prereleases=True), f"{wanted} but {pinned[name]}"
        if name not in seen:
            seen.add(name)
            waiting += [Requirement(text) for text in requires(name) or () if "extra ==" not in text]


def test_ci_runs_what_the_user_runs() -> None:
    script = ROOT / ".ci" / "run"
    assert os.access(script, os.X_OK)
    assert script.read_text().splitlines()[-1] == "make test"
    commands = subprocess.run(
        ["make", "--always-make", "--dry-run", "test"], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout
    steps = ("-m venv", "pip install", "testbed.warm", "ruff format --check", "ruff check", "mypy", "-m pytest")
    places = [commands.index(step) for step in steps]
    assert places == sorted(places)


def test_make_drive_passes_road_and_further_options_on() -> None:
    made = ["make", "--dry-run", "drive", "ROAD=A:20,D:300", "ARGS=--speed 100"]
    commands = subprocess.run(made, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    assert '-m testbed.drive --road "A:20,D:300" --speed 100' in commands


def cached_kernels(cache: Path) -> set[str]:
    """Files in a disk cache of kernels."""
    return {str(path) for path in cache.rglob("*.nb*")}


def test_after_warming_up_no_drive_compiles_anything(tmp_path: Path) -> None:
    """In a copy of the cache: whatever else runs on this machine at the same time writes into the shared one."""
    profile = tmp_path / "profile.txt"
    profile.write_text("".join(f"{0.3 * k} {0.002 * (k % 2)}\n" for k in range(60)))
    cache = Path(shutil.copytree(numba.config.CACHE_DIR, tmp_path / "cache"))
    apart = {**os.environ, "NUMBA_CACHE_DIR": str(cache)}
    subprocess.run([sys.executable, "-m", "testbed.warm"], check=True, capture_output=True, env=apart)
    before = cached_kernels(cache)
    assert before
    rough = ["--road", "D:10,B:20,F", "--leak", "fl=5@0", "--friction", "0.9/0.5", "--manoeuvre", "slalom"]
    even = ["--road", str(profile), "--obstacle", "cleat@8:height=20,length=30,side=left", "--driven", "rear"]
    common = ["--duration", "2", "--quiet", "--out", str(tmp_path / "drive.rrd")]
    code = f"from testbed.drive import main; assert main({common + rough}) == main({common + even}) == 0"
    subprocess.run([sys.executable, "-c", code], check=True, env=apart)
    assert cached_kernels(cache) - before == set()

"""`python -m testbed.bench`: measures what it says, prints it beside its bars, writes it as JSON."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from pathlib import Path

import mujoco
import pytest
from rich.console import Console

from testbed.bench import __main__ as bench
from testbed.bench.filter_bank import filter_bank_cost
from testbed.bench.loop_cost import HELD, bare_steps, loop_cost
from testbed.native import address
from testbed.scenario import Scenario
from testbed.simulation import Simulation

ISSUED = ("loop_over_mj_step", "realtime_factor", "recording_overhead", "two_thread_speedup", "peak_memory_mib")
SLACK = 1.5  # of a bar: a test shares its machine with others, only a real loss of speed may fail it


@pytest.fixture(scope="module")
def figures() -> dict[str, float]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bench, "WHOLE_DRIVE", 2.0)
        return bench.measure(
            bench.Effort(loop_seconds=3, drive=2.0, thread_drive=2.0, campaign_drives=2, repetitions=1)
        )


def test_every_figure_is_measured_and_possible(figures: dict[str, float]) -> None:
    assert set(bench.BARS) <= set(figures)
    assert set(ISSUED) <= set(figures)
    assert all(math.isfinite(value) for value in figures.values())
    assert figures["loop_step_us"] > figures["mj_step_us"] > 1.0
    assert 0.1 < figures["start_up_s"] < 120.0
    assert 0.3 < figures["two_thread_speedup"] < 2.5
    assert -0.5 < figures["campaign_overhead"] < 1.0
    assert 0.1 < figures["two_process_speedup"] < 4.0
    assert 100.0 < figures["peak_memory_mib"] < bench.BARS["peak_memory_mib"][1]


def test_loop_costs_at_most_its_bar() -> None:
    assert loop_cost(10).ratio < SLACK * bench.BARS["loop_over_mj_step"][1]


def test_compiled_filter_bank_keeps_its_bars() -> None:
    cost = filter_bank_cost(100, 3)
    assert cost.speedup > bench.BARS["imm_over_filterpy_speedup"][1] / SLACK
    assert cost.share < SLACK * bench.BARS["imm_four_wheels_cpu_share"][1]


def test_bare_steps_are_mujocos_own() -> None:
    """The same state, to the last bit, as the binding's mj_step."""
    simulation = Simulation(Scenario(road="flat", duration=1.0))
    ours, theirs = (mujoco.MjData(simulation.model) for _ in range(2))
    for data in (ours, theirs):
        mujoco.mj_copyData(data, simulation.model, simulation.data)
    bare_steps(address("mj_step"), simulation.model._address, ours._address, HELD)
    mujoco.mj_step(simulation.model, theirs, HELD)
    assert ours.time == theirs.time > simulation.data.time
    assert ours.qpos.tobytes() == theirs.qpos.tobytes()


def test_table_says_which_bar_is_missed(figures: dict[str, float]) -> None:
    console = Console(record=True, width=160)
    bench.print_table(console, figures | {"loop_over_mj_step": 2.01, "realtime_factor": 30.0})
    rows = {line.split()[0]: line for line in console.export_text().splitlines() if line.strip()}
    assert "missed" in rows["loop_over_mj_step"]
    assert "kept" in rows["realtime_factor"]


def test_json_that_cannot_be_written_is_told_before_measuring(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "testbed.bench", "--json", "/proc/nowhere/bench.json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=30.0)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert "nowhere" in done.stderr


def test_json_holds_the_figures_and_the_effort(
    figures: dict[str, float], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bench, "measure", lambda effort: figures)
    assert bench.main(["--quick", "--json", str(tmp_path / "bench.json")]) == 0
    written = json.loads((tmp_path / "bench.json").read_text())
    assert {key: written[key] for key in figures} == figures
    assert written["effort"]["repetitions"] == bench.QUICK.repetitions

"""Claims about a recording's plots: each wheel beside its truth, wholes stacked, bounds beside what they bound."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader

from testbed.recording import RecordingWriter
from tests.recording_contents import flat, layout, rows


def test_a_wheels_plot_shows_truth_and_estimate_and_is_wide_enough_for_truth_and_band(tmp_path: Path) -> None:
    with RecordingWriter(tmp_path / "a.rrd", {}) as writer:
        for wheel, mean in (("fl", 2.0), ("rr", -2.0)):
            writer.add(f"est/m/{wheel}/relative_radius_change", [0.0, 1.0], [mean, mean], "")
            writer.add(f"est/m/{wheel}/relative_radius_change/std", [0.0, 1.0], [3.0, 3.0], "")
        writer.add("truth/fl/relative_radius_change", [0.0, 1.0], [0.0, 9.0], "")
    reader = RrdReader(tmp_path / "a.rrd")
    chunks = reader.stream(store=reader.blueprints()[0]).to_chunks()
    batches = [b for b in (chunk.to_record_batch() for chunk in chunks) if "ScalarAxis:range" in b.schema.names]
    ends = sorted(flat(batch, "ScalarAxis:range").tolist() for batch in batches)
    # a twentieth beyond: the band of rr from -5 to 1, that of fl from -1 to 5 with its truth up to 9
    assert ends == [pytest.approx([-5.3, 1.3]), pytest.approx([-1.5, 9.5])]
    asked, _ = layout(tmp_path / "a.rrd")
    assert {
        "/truth/fl/relative_radius_change",
        "/est/m/fl/relative_radius_change/band",
        "/est/m/rr/relative_radius_change/band",
    } == asked


def test_a_log_without_truth_shows_what_its_sensors_say(tmp_path: Path) -> None:
    with RecordingWriter(tmp_path / "a.rrd", {}) as writer:
        writer.add("tyre/fl/pressure", [0.0], [250e3], "Pa")
        writer.add("driver/accelerator", [0.0], [0.1], "")
    assert layout(tmp_path / "a.rrd") == ({"/tyre/fl/pressure"}, set())


def test_road_classes_are_stacked_to_one(tmp_path: Path) -> None:
    """Each class's band begins where the one below ends; the round that is open at the end is drawn too."""
    time, shares = [0.0, 1.0], {"A": [0.2, 0.1], "B": [0.5, 0.3], "C": [0.3, 0.6]}
    with RecordingWriter(tmp_path / "a.rrd", {}) as writer:
        for start in (0.0, 2.0):
            for name in ("B", "C", "A"):
                for ending, value in (("", shares[name]), ("/std", [0.0, 0.0])):
                    writer.add(f"est/m/road/{name}{ending}", [t + start for t in time], value, "")
    below = np.zeros(4)
    for name, share in shares.items():
        batches = rows(tmp_path / "a.rrd", f"/est/m/road/{name}/band")
        middle = np.concatenate([flat(b, "Measurements:values") for b in batches])
        half = np.sqrt(np.concatenate([flat(b, "Measurements:variances") for b in batches]))
        assert middle - half == pytest.approx(below, abs=1e-12)
        below = middle + half
        assert below - (middle - half) == pytest.approx(share * 2)
    assert below == pytest.approx(np.ones(4))
    assert layout(tmp_path / "a.rrd")[0] == {f"/est/m/road/{name}/band" for name in shares}


def test_a_bound_is_drawn_beside_the_deviations_that_it_bounds(tmp_path: Path) -> None:
    with RecordingWriter(tmp_path / "a.rrd", {}) as writer:
        for name, value in (("stiffness", 2e5), ("pressure", 2e5), ("pressure_bound", 5e3)):
            writer.add(f"est/m/fl/{name}", [0.0], [value], "Pa")
            writer.add(f"est/m/fl/{name}/std", [0.0], [7e3], "Pa")
    reader = RrdReader(tmp_path / "a.rrd")
    batches = [c.to_record_batch() for c in reader.stream(store=reader.blueprints()[0]).to_chunks()]
    contents = [
        b.column("ViewContents:query").flatten().to_pylist() for b in batches if "ViewContents:query" in b.schema.names
    ]
    assert ["/est/m/fl/pressure/std", "/est/m/fl/pressure_bound"] in contents


def test_active_steering_has_its_tab_only_where_there_is_one(tmp_path: Path) -> None:
    names = {"steering/angle", "steering/motor_demand", "steering/motor_angle", "truth/steering/pinion_angle"}
    for active in (False, True):
        with RecordingWriter(tmp_path / "a.rrd", {}) as writer:
            for name in names if active else {"steering/angle"}:
                writer.add(name, [0.0, 1.0], [0.1, 0.2], "rad")
            writer.add("truth/chassis/speed", [0.0], [1.0], "m/s")
        asked, _ = layout(tmp_path / "a.rrd")
        assert asked == {"/truth/chassis/speed"} | ({f"/{name}" for name in names} if active else set())

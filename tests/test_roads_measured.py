"""Claims about measured roads (OpenCRG, profile text), obstacles, the start and the International Roughness Index."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from testbed.roads import make_road
from testbed.roads.iri import iri, iri_of_road
from testbed.roads.opencrg import CrgRoad, fill_missing
from testbed.roads.profile import ProfileRoad, read_profile
from testbed.roads.spectrum import fitted_gd, iso_class
from testbed.roads.turning_path import KEPT, TurningPath
from tests.conftest import Claim

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
FILES = {
    "belgian": "belgian_block.crg",
    "krc": "krc_rms_course_2in.crg",
    "utia": "iri_utia_profile_1.txt",
}


def data_file(name: str) -> str:
    path = DATA / FILES[name]
    if not path.is_file():
        pytest.skip(f"measured data absent: {path}")
    return str(path)


def test_belgian_block_first_pass_is_as_measured() -> None:
    path = data_file("belgian")
    import pyopencrg

    patch = pyopencrg.read(path)
    road = make_road(path, 1, 20.0, 60.0).raw
    assert road.spacing == 0.01
    u, v = 0.01 * np.arange(0, 1001), 0.01 * np.arange(-130, 131)
    z = road.heights(u, v)
    measured = patch.surface_z().T[40:301]
    known = np.isfinite(measured)
    shift = (z - measured)[known]
    assert np.ptp(shift) < 1e-9
    assert known.mean() > 0.95
    assert np.isfinite(z).all()


def test_belgian_block_goes_on_continuously_and_without_period() -> None:
    road = make_road(data_file("belgian"), 1, 20.0, 60.0).raw
    x = 0.01 * np.arange(30000)
    z = road.heights(x, np.array([-1.5, 0.0, 0.8]))
    first = np.abs(np.diff(z[:, :1001], axis=1)).max()
    assert np.abs(np.diff(z, axis=1)).max() <= first + 1e-12  # nowhere steeper than measured
    assert set(np.round(z[1], 9)) <= set(np.round(z[1, :1001], 9))  # nothing invented
    slope = np.diff(z[2])
    power = np.abs(np.fft.rfft(slope, 2 * len(slope))) ** 2
    correlation = np.fft.irfft(power)[: len(slope)]
    assert correlation[1500:].max() / correlation[0] < 0.6  # a 20 m period would give 0.9 at its first return


def test_road_holds_its_edge_beyond_its_width() -> None:
    z = np.arange(20.0).reshape(5, 4)
    road = CrgRoad("made", z, 0.05, np.array([-1.5, -0.5, 0.5, 1.5]), 1)
    got = road.heights(0.05 * np.arange(5), np.array([-9.0, -1.5, 1.5, 9.0]))
    np.testing.assert_array_equal(got[0], got[1])
    np.testing.assert_array_equal(got[2], got[3])
    np.testing.assert_allclose(np.diff(got[0]), 4.0)


def test_missing_cells_are_filled_across_then_along() -> None:
    nan = np.nan
    filled = fill_missing(np.array([[nan, 1.0, nan, 3.0, nan], [nan] * 5, [5.0, 5.0, 5.0, 5.0, 5.0]]))
    np.testing.assert_array_equal(filled[0], [1.0, 1.0, 2.0, 3.0, 3.0])
    np.testing.assert_array_equal(filled[1], [3.0, 3.0, 3.5, 4.0, 4.0])
    with pytest.raises(ValueError, match="no cell"):
        fill_missing(np.full((3, 3), nan))


def test_krc_course_is_flat_then_undulated_and_alike_in_both_tracks() -> None:
    road = make_road(data_file("krc"), 1, 20.0, 60.0).raw
    z = road.heights(0.05 * np.arange(10000), np.array([-0.8, 0.8]))
    np.testing.assert_allclose(z[0], z[1], atol=1e-9)
    undulated = z[0, 2000:8096]
    assert np.std(undulated) > 5.0 * np.std(z[0, :1500])
    # the file's comment: detrended RMS 1.7441 in over the undulated surface
    assert np.std(undulated) == pytest.approx(1.7441 * 0.0254, rel=0.05)


@pytest.mark.parametrize("cells", [1, 2, 7, 1000])
def test_turning_path_walks_cell_by_cell_within_the_patch(cells: int) -> None:
    distance = np.arange(-5.0, 40.0 * cells)
    places = TurningPath(cells, 3).places(distance)
    assert places.min() == 0.0
    assert places.max() == cells
    assert set(np.abs(np.diff(places[5:]))) == {1.0}
    np.testing.assert_array_equal(places[5 : 6 + cells], np.arange(cells + 1))
    np.testing.assert_array_equal(TurningPath(cells, 3).places(distance[-9:]), places[-9:])


def test_an_endless_road_takes_no_endless_memory() -> None:
    path = TurningPath(100, 3)
    ends = [path.places(np.arange(k, k + 50.0)) for k in range(0, 2_000_000, 500)]
    assert max(end.max() for end in ends) <= 100.0
    assert len(path._starts) < 2 * KEPT
    again = TurningPath(100, 3).places(np.arange(1_999_500, 1_999_550.0))
    np.testing.assert_array_equal(ends[-1], again)
    with pytest.raises(ValueError, match="forgotten"):
        path.places(np.arange(10.0))


def test_turning_path_turns_at_many_places() -> None:
    places = TurningPath(1000, 3).places(np.arange(40000.0))
    turns = np.flatnonzero(np.diff(np.sign(np.diff(places)))) + 1
    assert len(set(np.diff(turns))) > 0.9 * len(turns) > 30


def test_utia_profile_passes_through_its_points() -> None:
    path = data_file("utia")
    x, z = read_profile(path)
    road = make_road(path, 1, 20.0, 60.0).raw
    got = road.heights(x - x[0], np.array([-0.8, 0.8]))
    np.testing.assert_allclose(got, np.vstack([z - z[0]] * 2), atol=1e-9)
    assert iso_class(fitted_gd(road.heights(0.05 * np.arange(10880), np.zeros(1))[0], 0.05)) == "B"


def test_iri_of_utia_profile_is_3_3(claim: Claim) -> None:
    path = data_file("utia")
    x, z = read_profile(path)
    published, tolerance = 3.3, 0.1  # [m/km]
    claim("IRI of a measured profile is 3.3 m/km", abs(iri(z, 0.25) - published), tolerance, "m/km")
    road = make_road(path, 1, 20.0, 60.0).raw
    assert iri_of_road(road, x[-1] - x[0], 0.8) == pytest.approx(published, abs=tolerance)


@pytest.mark.parametrize("wave", [2.0, 10.0, 30.0])
def test_iri_of_a_sine_is_its_closed_form(wave: float) -> None:
    """Golden car of ASTM E1926, its transfer function written out: K1 653, K2 63.3 1/s^2, mu 0.15, C 6.0 1/s, 80 km/h;
    the moving average takes sinc(0.25 m / wave), the mean of |sine| is 2/pi."""
    spacing, amplitude = 0.05, 0.01
    x = spacing * np.arange(40001)
    s = 2j * np.pi * (80.0 / 3.6) / wave
    strut, tyre, mass = 6.0 * s + 63.3, 653.0, 0.15
    sprung = strut / (s**2 + strut)  # z_s over z_u
    unsprung = tyre / (mass * s**2 + tyre + strut * (1.0 - sprung))  # z_u over the road
    slope = amplitude * 2.0 * np.pi / wave * np.sinc(0.25 / wave)
    expected = 1000.0 * abs((sprung - 1.0) * unsprung) * slope * 2.0 / np.pi
    assert iri(amplitude * np.sin(2.0 * np.pi * x / wave), spacing) == pytest.approx(expected, rel=0.01)


def test_iri_scales_with_height_and_ignores_grade() -> None:
    z = make_road("B", 1, 20.0, 60.0).raw.heights(0.05 * np.arange(8000), np.zeros(1))[0]
    assert iri(3.0 * z, 0.05) == pytest.approx(3.0 * iri(z, 0.05), rel=1e-9)
    assert iri(z + 0.05 * 0.05 * np.arange(8000), 0.05) == pytest.approx(iri(z, 0.05), rel=0.02)


@pytest.mark.parametrize(("z", "spacing"), [(np.zeros(10), 0.05), (np.full(900, np.nan), 0.05), (np.zeros(900), 0.5)])
def test_iri_refuses_short_missing_and_coarse_profiles(z: np.ndarray, spacing: float) -> None:
    with pytest.raises(ValueError, match="IRI needs"):
        iri(z, spacing)


def test_ground_beside_and_behind_the_starting_lane_is_as_rough_as_the_road() -> None:
    """A circle that comes back behind the start meets class C there too; only the lane to the start is flat."""
    road = make_road("C", 1, 20.0, 60.0)
    behind, ahead = 0.05 * np.arange(-4000, -3000), 0.05 * np.arange(1000, 2000)
    y = 0.05 * np.arange(200, 220)
    roughness = [np.std(np.diff(road.heights(x, y), axis=1)) for x in (behind, ahead)]
    assert roughness[0] == pytest.approx(roughness[1], rel=0.1)
    assert not road.heights(behind, 0.05 * np.arange(-60, 61)).any()
    across = np.abs(np.diff(road.heights(behind, 0.05 * np.arange(50, 200)), axis=0))
    assert across.max() < 0.03  # m from node to node: no step at the lane's edge


def test_car_starts_on_level_ground_and_then_climbs() -> None:
    road = make_road("H", 1, 20.0, 60.0, grade=0.1, bank=-0.02)
    x, y = 0.05 * np.arange(-200, 2000), 0.05 * np.arange(-20, 21)
    z = road.heights(x, y)
    assert not z[:, :201].any()
    plane = z - road.raw.heights(x, y) * (x > 0)
    far = x >= 10.0
    np.testing.assert_allclose(plane[:, far], (0.1 * (x[far] - 5.0))[None] - 0.02 * y[:, None], atol=1e-9)


def test_obstacles_have_their_volume_place_and_side() -> None:
    cleat, pothole = "cleat@50:height=20,length=33,side=left", "pothole@80:depth=60,length=400"
    road = make_road("flat", 1, 20.0, 60.0, obstacles=[cleat, pothole])
    assert road.spacing == 0.01
    x, y = 0.01 * np.arange(4900, 8200), np.array([-0.8, -0.05, 0.05, 0.8])
    z = road.heights(x, y)
    near_cleat = x < 60.0
    np.testing.assert_allclose(z[:, near_cleat].sum(axis=1) * 0.01, [0.0, 0.0, 0.020 * 0.033, 0.020 * 0.033])
    np.testing.assert_allclose(z[:, ~near_cleat].sum(axis=1) * 0.01, -0.060 * 0.400)
    assert z.max() == pytest.approx(0.020)
    assert z.min() == pytest.approx(-0.060)
    first = x[np.flatnonzero(z[3] > 0.0)[0]]
    assert first == pytest.approx(50.0, abs=0.006)


def test_profile_does_not_overshoot_a_step() -> None:
    x = np.arange(20.0)
    road = ProfileRoad("made", x, (x >= 10.0).astype(float), 1)
    z = road.heights(0.05 * np.arange(381), np.zeros(1))[0]
    assert z.min() == 0.0
    assert z.max() == 1.0

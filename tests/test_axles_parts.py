"""Alignment, lost coherence, evidence, alarm and calibration of `axles`, each against something derived otherwise."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import k1

from estimators.axles.axles import Axles as Estimator
from estimators.axles.block import BINS, FREQUENCIES
from estimators.axles.calibration import USUAL, basis, from_document, maker_axles, sound_from, to_document
from estimators.axles.delay import FrontDelay
from estimators.axles.evidence import evidence
from estimators.axles.identify import KnownRoad, identify
from estimators.axles.likelihood import STATES
from estimators.axles.motion import Motion, line, stretch
from estimators.axles.off_tracking import SLIP_PER_ACCELERATION, STRAIGHT, coherency, offset
from estimators.axles.response import hub_responses
from estimators.axles.side import NOISE
from estimators.axles.watch import DRIFT, FRONT_LOST, LARGEST, LEARNING, REAR_LOST, THRESHOLD, Watch
from estimators.car import Car
from estimators.vertical_pressure.intake import BLOCK
from models.identified import identified

WHEELBASE = 2.8


@pytest.mark.parametrize("acceleration", [0.0, 1.5, -2.0])
def test_front_is_heard_where_the_rear_wheel_is_though_the_speed_changes(acceleration: float) -> None:
    """A road of one wave, z = sin(2 pi s / 1.3 m): the delayed front is the rear's own z to 0.3 %."""
    delay, worst = FrontDelay(WHEELBASE), 0.0
    for block in range(12):
        t = (np.arange(BLOCK) + 0.5 + block * BLOCK) * 1e-3
        speed, place = 14.0 + acceleration * t, 14.0 * t + 0.5 * acceleration * t**2
        heard = delay.block(np.sin(2.0 * np.pi * (place + WHEELBASE) / 1.3), speed)
        if block > 1:
            worst = max(worst, float(np.abs(heard - np.sin(2.0 * np.pi * place / 1.3)).max()))
    assert worst < 3e-3


def test_delay_is_silent_until_the_rear_wheel_is_there_and_where_the_front_was_not_heard() -> None:
    delay = FrontDelay(WHEELBASE)
    first = delay.block(np.ones(BLOCK), np.full(BLOCK, 20.0))
    assert int(np.isfinite(first).sum()) == pytest.approx(BLOCK - 140, abs=4)
    gone = np.ones(BLOCK)
    gone[100:110] = np.nan
    delay.block(gone, np.full(BLOCK, 20.0))
    heard = delay.block(np.ones(BLOCK), np.full(BLOCK, 20.0))
    assert np.isfinite(heard[: 240 - BLOCK - 4]).all()
    second = FrontDelay(WHEELBASE)
    assert np.isnan(second.block(np.ones(BLOCK), np.full(BLOCK, np.nan))).all()


def test_a_common_road_is_lost_with_the_offset_of_the_tracks() -> None:
    speed, d = 15.0, 0.12
    rho = 2.0 * np.pi * FREQUENCIES / speed * (d - STRAIGHT)
    assert coherency(d, speed) == pytest.approx(rho * k1(rho))
    assert coherency(0.0, speed) == pytest.approx(1.0)
    assert coherency(20.0, speed).max() < 1e-6
    turn = 0.1  # rad/s at 10 m/s: R = 100 m
    wanted = 0.5 * WHEELBASE**2 / 100.0 + WHEELBASE * SLIP_PER_ACCELERATION
    assert offset(turn, 10.0, WHEELBASE) == pytest.approx(wanted)
    assert offset(-turn, 10.0, WHEELBASE) == pytest.approx(wanted)


def test_motion_of_a_block_is_a_straight_line_without_the_wheel_that_lies() -> None:
    car = Car()
    time = (np.arange(BLOCK) + 0.5) * 1e-3
    wheels = np.full((BLOCK, 4), np.nan)
    wheels[::10] = ((20.0 + 2.0 * time[:, None]) / car.rolling_radius)[::10]
    wheels[::10, 2] = 0.0  # a dead sensor
    motion = Motion(car, wheels, np.full(BLOCK, 0.2))
    assert motion.speed[0] == pytest.approx(20.0 + 2.0 * time, abs=1e-9)
    assert motion.acceleration == pytest.approx(2.0)
    assert motion.yaw_rate == pytest.approx(0.2)
    empty = Motion(car, np.full((BLOCK, 4), np.nan), np.full(BLOCK, np.nan))
    assert np.isnan(empty.speed).all()
    assert np.isnan(empty.mean)
    assert np.isnan(line(np.full(BLOCK, np.nan))[0])
    assert stretch(10.0, 1.5, WHEELBASE) == pytest.approx(np.sqrt(10.0**2 - 2.0 * 1.5 * WHEELBASE) / 10.0)


def test_evidence_of_a_block_is_the_estimate_with_all_else_integrated_out() -> None:
    """Of a Gaussian likelihood: the marginal over the others under their prior is known in closed form."""
    rng = np.random.default_rng(2)
    root = rng.standard_normal((STATES, STATES))
    J, spread = root @ root.T, rng.standard_normal((STATES, STATES))
    P, theta, score = spread @ spread.T + np.eye(STATES), rng.standard_normal(STATES), rng.standard_normal(STATES)
    found = evidence(theta, P, score, J)
    for row, (value, variance) in zip(([1.0, -1.0], [0.5, 0.5]), found, strict=True):
        # the other stiffness direction, and the rest, with their prior; the direction itself with next to none
        turn = np.eye(STATES)
        turn[:2, :2] = [[1.0, -1.0], [0.5, 0.5]] if row[1] < 0.0 else [[0.5, 0.5], [1.0, -1.0]]
        back = np.linalg.inv(turn)
        prior = np.linalg.inv((turn @ P @ turn.T)[1:, 1:])
        whole = back.T @ J @ back
        whole[1:, 1:] += prior
        C = np.linalg.inv(whole)
        assert variance == pytest.approx(C[0, 0])
        assert value == pytest.approx((turn @ theta)[0] + (C @ back.T @ score)[0])


def listening(watch: Watch, values: NDArray[np.float64], std: float = 0.04) -> list[str]:
    said = [watch.step(float(v), std**2, 0.0, 0.256) for v in values]
    return [word for word in said if word is not None]


def test_watch_learns_then_names_the_end_that_changed() -> None:
    rng = np.random.default_rng(3)
    sound = 0.03 + 0.03 * rng.standard_normal(400)
    for change, wanted in ((-0.104, FRONT_LOST), (0.104, REAR_LOST)):
        watch = Watch()
        assert listening(watch, sound) == []
        assert watch.reference == pytest.approx(0.03, abs=0.01)
        assert listening(watch, 0.03 + change + 0.03 * rng.standard_normal(60)) == [wanted]
        assert watch.alarmed
    assert Watch().reference is None
    brief = Watch()
    assert listening(brief, np.full(int(LEARNING / 0.256) - 1, 0.5)) == []
    assert brief.reference is None


def test_watch_knows_a_loss_from_before_the_drive_by_what_it_learnt_before_and_follows_what_is_slow() -> None:
    assert listening(Watch((0.02, 0.004)), np.full(60, -0.09)) == [FRONT_LOST]
    watch = Watch((0.02, 0.004))
    assert listening(watch, np.linspace(0.02, 0.05, 3000)) == []
    assert watch.reference == pytest.approx(0.05, abs=0.02)


def test_no_single_block_alarms_and_what_says_nothing_moves_nothing() -> None:
    watch = Watch((0.0, 0.004))
    blocks = int(np.ceil(THRESHOLD / (LARGEST - DRIFT)))
    assert listening(watch, np.full(blocks - 1, 50.0)) == []
    before = watch.statistic
    assert watch.step(50.0, np.inf, 0.0, 0.256) is None
    assert watch.statistic == before


def test_identification_finds_axles_and_tables_from_what_they_make() -> None:
    """From exact spectral matrices of a car off the maker's numbers: H is found again, at a speed not driven."""
    maker = maker_axles(Car())
    true = maker.axles._replace(
        front=maker.axles.front._replace(damping=3300.0, footprint=0.13),
        rear=maker.axles.rear._replace(unsprung_mass=41.0),
        coupling=0.8 * maker.axles.coupling,
    )
    roads, H = [], np.empty((2, BINS), complex)
    for speed in (9.0, 13.0, 18.0, 25.0):
        for kf, kr in ((230e3, 250e3), (250e3, 220e3), (190e3, 190e3)):
            hub_responses(true, kf, kr, speed, 1.0, FREQUENCIES, H)
            S = 1e-5 * np.einsum("in,jn->nij", H, H.conj())
            S[:, 1, 0] *= 0.99
            S[:, 0, 1] *= 0.99
            roads.append(KnownRoad(S + NOISE * np.eye(2), np.array([kf, kr]), speed))
    found = identify(maker, roads)
    assert found.axles.front.damping == pytest.approx(3300.0, rel=0.05)
    wanted, got = np.empty((2, BINS), complex), np.empty((2, BINS), complex)
    hub_responses(true, 225e3, 205e3, 15.0, 1.0, FREQUENCIES, wanted)
    hub_responses(found.axles, 225e3, 205e3, 15.0, 1.0, FREQUENCIES, got)
    got *= found.shape(15.0) * np.exp(found.bend(15.0) * (0.5 * np.log(225e3 * 205e3) - np.log(250e3)))
    assert np.abs(got[1] / got[0] / (wanted[1] / wanted[0]) - 1.0).max() < 0.01
    with pytest.raises(ValueError, match="at least 12"):
        identify(maker, roads[:3])


def test_tables_count_by_comb_stiffness_and_speed_and_not_at_their_reference() -> None:
    at_reference, elsewhere = basis(0.0, USUAL, WHEELBASE), basis(0.2, USUAL * np.e, WHEELBASE)
    assert not at_reference[3:].any()
    assert elsewhere[3:6] == pytest.approx(0.2 * elsewhere[:3])
    assert elsewhere[6] == pytest.approx(1.0)
    phase = 2.0 * np.pi * FREQUENCIES * WHEELBASE / USUAL
    assert at_reference[1] + 1j * at_reference[2] == pytest.approx(np.exp(1j * phase))


def test_documents_there_and_back_and_what_is_wrong_with_them() -> None:
    document = identified()["axles"]
    assert to_document(from_document(document)) == document
    for change, words in (
        ({"wheelbase": 0.0}, "wheelbase is 0"),
        ({"coupling": "x"}, "coupling is 'x'"),
        ({"front": {}}, "calibration of front"),
        ({"rear": document["rear"] | {"damping": -1.0}}, "damping is -1"),
        ({"level": [[0.0]]}, r"level has shape \(1, 1\)"),
    ):
        with pytest.raises(ValueError, match=words):
            from_document(document | change)
    with pytest.raises(ValueError, match="lacks 'ratio_real'"):
        from_document({name: value for name, value in document.items() if name != "ratio_real"})
    assert sound_from({"left": [0.1, 0.01]}) == {"left": (0.1, 0.01)}
    for wrong in ({"front": [0.0, 1.0]}, {"left": [0.0]}, {"left": [0.0, 0.0]}, 3):
        with pytest.raises(ValueError, match="sound"):
            sound_from(wrong)
    estimator = Estimator(Car())
    assert estimator.calibration() is None
    known = document | {"sound": {"right": [0.01, 0.004]}}
    estimator.use_calibration(known)
    assert estimator.calibration() == known

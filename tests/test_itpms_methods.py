"""Claims about the parts of `itpms`, each against a closed form, a second derivation or its own statistics."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import integrate, signal, stats

from estimators.car import Car
from estimators.drive_log import WHEELS
from estimators.itpms.contrasts import DIAGONAL, FRONT_REAR, LEFT_RIGHT, Contrasts, RadiusBlock
from estimators.itpms.frequency_blocks import BETWEEN, FrequencyBlocks
from estimators.itpms.learning import LearningBlock, learn
from estimators.itpms.mode_grid import ANTIPHASE, BLOCK, IN_PHASE, RATE, SIZE, ModeGrid
from estimators.itpms.mode_nodes import ANTIPHASE as FAST_MODE
from estimators.itpms.mode_nodes import MODE_NODES, NODES, remaining
from estimators.itpms.monitor import SAME_ROAD, SENSITIVITY, Block, Monitor, same_road, walk_covariance
from estimators.itpms.patterns import ALIKE, LEAST, PATTERNS, SPREAD, TYPICAL, judge
from estimators.itpms.sound_car import LEAK, ONSETS, STATES, SoundCar
from estimators.itpms.speed_bins import NAMES, Calibration
from estimators.itpms.summary import PRIOR, summary
from estimators.itpms.thresholds import TUNED
from estimators.itpms.warming import GAIN, TAU, Warming
from estimators.wheel_radius.motion import Motion
from estimators.wheel_radius.wheel_change import CONTRASTS

BLOCKS = 400  # of a simulated mode: its mean is then known to a twentieth of a block's std
LINE_WIDTH = 3.0  # Hz either way of a line: the sine tapers' band and the side lobes next to it
OVER_BOUND = 2.2  # of the Cramer-Rao bound: damping, slope, bend and noise are not known, and blocks are short


def mode(frequency: float, damping: float, noise: float, rng: np.random.Generator) -> np.ndarray:
    """Blocks of a mode driven by white noise, plus white noise of a PSD `noise` times the peak's, (BLOCKS, SIZE)."""
    w, dt = 2.0 * math.pi * frequency, 1.0 / RATE
    roots = np.exp(dt * w * (-damping + np.array([1j, -1j]) * math.sqrt(1.0 - damping**2)))
    a = np.real(np.poly(roots))
    y = signal.lfilter([1.0], a, rng.standard_normal(BLOCKS * SIZE + 4000))[4000:]
    peak = 1.0 / np.abs(np.polyval(a[::-1], np.exp(-1j * w * dt)))
    return (y + math.sqrt(noise) * peak * rng.standard_normal(len(y))).reshape(BLOCKS, SIZE)


@pytest.fixture(scope="module")
def grid() -> ModeGrid:
    return ModeGrid(ANTIPHASE)


@pytest.mark.parametrize(("frequency", "noise"), [(87.0, 0.0), (87.0, 0.1), (81.0, 0.03)])
def test_mode_frequency_is_unbiased_and_as_uncertain_as_it_says(grid: ModeGrid, frequency: float, noise: float) -> None:
    speed = mode(frequency, 0.07, noise, np.random.default_rng(1))
    found = grid.fit(speed, np.ones((BLOCKS, len(grid.frequency)), bool))
    told = np.isfinite(found[:, 0])
    error = found[told, 0] - math.log(frequency)
    assert told.mean() > 0.95
    weight = found[told, 1] ** -2.0
    assert abs(np.sum(weight * error) / weight.sum()) < 3e-3  # a loss of 1 % of the pressure
    assert 0.7 < math.sqrt(np.mean((error / found[told, 1]) ** 2)) < 1.3
    bound = math.sqrt(0.07 / (2.0 * math.pi * frequency * BLOCK))
    assert bound < error.std() < OVER_BOUND * bound * (1.0 + 3.0 * noise)


@pytest.mark.parametrize("slope", [-3.75, -1.25])
def test_a_road_between_two_slopes_of_the_grid_moves_and_scatters_no_frequency(grid: ModeGrid, slope: float) -> None:
    """Whatever the road's slope, blocks scatter by what they say (a grid of steps of 4 scattered by 1.5 times that)."""
    whole = np.fft.rfft(mode(87.0, 0.072, 0.0, np.random.default_rng(11)).ravel())
    f = np.fft.rfftfreq(BLOCKS * SIZE, 1.0 / RATE)
    speed = np.fft.irfft(whole * np.maximum(f / 83.0, 0.05) ** (0.5 * slope)).reshape(BLOCKS, SIZE)
    found = grid.fit(speed, np.ones((BLOCKS, len(grid.frequency)), bool))
    error = found[:, 0] - math.log(87.0)
    assert abs(error.mean()) < 5e-3  # the same at every block, so learnt
    assert 0.8 < math.sqrt(np.mean((error / found[:, 1]) ** 2)) < 1.1
    assert error.std() < OVER_BOUND * math.sqrt(0.072 / (2.0 * math.pi * 87.0 * BLOCK))


def test_masked_wheel_order_moves_nothing_and_an_unmasked_one_does(grid: ModeGrid) -> None:
    speed = mode(87.0, 0.07, 0.0, np.random.default_rng(2))[:50]
    line = 4.0 * speed.std() * np.cos(2.0 * math.pi * 100.0 * np.arange(SIZE) / RATE)
    every = np.ones((50, len(grid.frequency)), bool)
    masked = every & (np.abs(grid.frequency - 100.0) > LINE_WIDTH)
    plain, hidden = grid.fit(speed, masked)[:, 0], grid.fit(speed + line, masked)[:, 0]
    assert hidden == pytest.approx(plain, abs=2e-3, nan_ok=True)
    assert np.nanmean(grid.fit(speed + line, every)[:, 0]) > math.log(87.0) + 0.05


def test_the_in_phase_mode_is_read_at_a_steady_speed_alone() -> None:
    """Either side of the declared change of speed, on wheels whose tooth rings are known."""
    car, rng = Car(), np.random.default_rng(4)
    time = (np.arange(SIZE) + 0.5) / RATE - 0.5 * BLOCK
    for share, heard in ((0.9, True), (-0.9, True), (1.1, False), (-1.1, False)):
        blocks = FrequencyBlocks(car)
        for tracker in blocks._trackers:
            tracker.ring.turns[:] = 1e6
        ramp = share * IN_PHASE.steadiest * time
        assert abs(ramp[-SIZE // 4 :].mean() - ramp[: SIZE // 4].mean()) == pytest.approx(
            BETWEEN * abs(share) * IN_PHASE.steadiest
        )
        rolling = (13.0 + ramp) / car.rolling_radius
        blocks._speed = [
            rolling + 1e-3 * mode(42.0, 0.15, 0.0, rng)[0] + 1e-3 * mode(85.0, 0.07, 0.0, rng)[0] for _ in WHEELS
        ]
        blocks._first = [0] * 4
        found = np.isfinite(blocks.block(0)[..., 0])
        assert found[0].all()
        assert found[1].all() == heard
        assert found[1].any() == heard


def test_noise_alone_says_nothing_or_hardly_anything(grid: ModeGrid) -> None:
    found = grid.fit(np.random.default_rng(3).standard_normal((200, SIZE)), np.ones((200, len(grid.frequency)), bool))
    weight = np.where(np.isfinite(found[:, 1]), found[:, 1] ** -2.0, 0.0)
    assert weight.mean() < 0.1 * 0.02**-2.0  # of what a block of a driven mode says


def test_likelihood_ratio_of_a_loss_is_that_of_the_joint_gaussian() -> None:
    """Recursion over 6 blocks of 2 measurements against the density of all 12 at once, for a sudden loss and a leak."""
    rng = np.random.default_rng(4)
    prior, walk = np.eye(STATES) * 0.5, np.eye(STATES) * 0.01
    car, seconds, blocks = SoundCar(prior), 2.0, 6
    rows, losses = rng.standard_normal((2 * blocks, STATES)), rng.standard_normal((2 * blocks, 4))
    value, variance = rng.standard_normal(2 * blocks), rng.uniform(20.0, 30.0, 2 * blocks)  # no Huber weight
    for block in range(blocks):
        car.begin(block, seconds, walk, None)
        for k in (2 * block, 2 * block + 1):
            car.take(rows[k], losses[k], value[k], variance[k])
    number = np.arange(2 * blocks) // 2
    covariance = np.diag(variance)
    for i in range(2 * blocks):
        for j in range(2 * blocks):
            covariance[i, j] += rows[i] @ (prior + walk * (1 + min(number[i], number[j]))) @ rows[j]
    density = stats.multivariate_normal(np.zeros(2 * blocks), covariance).logpdf
    d = np.array([-0.2, 0.1, 0.0, -0.3])
    for place, (onset, rise) in enumerate(zip(car.onsets, car.rise, strict=True)):
        age = seconds * (number - onset + 0.5)
        share = np.clip(age / LEAK, 0.0, 1.0) if rise else 1.0
        effect = np.where(number >= onset, share, 0.0) * (losses @ d)
        ratio = car.score[place] @ d - 0.5 * d @ car.information[place] @ d
        assert ratio == pytest.approx(density(value - effect) - density(value), abs=1e-9)


def test_noise_that_two_wheels_of_a_side_share_is_that_of_the_joint_gaussian() -> None:
    """One block of the four antiphase frequencies: information about losses against G' (H P H' + R)^-1 G, R full."""
    nodes, mode = len(NODES), MODE_NODES[0]
    sure = tuple(np.array([1e6 * np.eye(mode.count)] * 4) for mode in MODE_NODES)
    known = Calibration(np.zeros((len(NAMES), nodes)), sure, np.zeros((3, nodes)), (0.0, 0.0), np.zeros(2), np.zeros(2))
    monitor, frequency = Monitor(Car(), known, "vibration"), np.full((2, 4, 2), np.nan)
    std = np.array([0.02, 0.015, 0.025, 0.018])
    frequency[0, :, 0], frequency[0, :, 1] = 0.0, std
    unread = RadiusBlock(np.empty(0), np.empty((0, 3)), 0.0, 0.0, 0.0, math.nan, math.nan)
    prior = monitor._car.covariance + walk_covariance(BLOCK)
    assert monitor.step(Block(0, frequency, unread, 20.0)) is not None
    rows = np.zeros((4, STATES))
    for wheel in range(4):
        rows[wheel, wheel * mode.count : (wheel + 1) * mode.count] = mode.weights(20.0)
    shared = np.eye(4) + SAME_ROAD * (np.eye(4, k=2) + np.eye(4, k=-2))
    total = rows @ prior @ rows.T + np.outer(std, std) * shared
    assert monitor.information(0, 0.0) == pytest.approx(SENSITIVITY[0] ** 2 * np.linalg.inv(total), rel=1e-6)
    assert same_road(0, 10.0) == same_road(1, 20.0) == 0.0


def test_onsets_stay_few_and_keep_the_first_and_the_likeliest() -> None:
    car, likeliest = SoundCar(np.eye(STATES)), None
    for block in range(500):
        likeliest = car.begin(block, 2.0, np.zeros((STATES, STATES)), likeliest)
        if block == 100:
            likeliest = int(np.flatnonzero((car.onsets == 100) & (car.rise == 0.0))[0])
    assert likeliest is not None
    assert car.onsets[likeliest] == 100
    assert car.onsets[0] == 0
    for rise, most in zip((0.0, LEAK), ONSETS, strict=True):
        kept = car.onsets[car.rise == rise]
        assert len(kept) == most
        ages = 500 - kept[:-1][kept[:-1] != 100]
        assert (ages[:-1] / ages[1:]).max() < 2.2  # some onset is near whatever happened


def _evidence(score: np.ndarray, information: np.ndarray, low: list[int]) -> float:
    """ln of the mean likelihood of losses of the low wheels beyond LEAST, by quadrature (alike to 0 here)."""

    def density(x: float) -> float:
        d = np.zeros(4)
        d[low] = x
        return float(np.exp(score @ d - 0.5 * d @ information @ d) * stats.norm.pdf(x, TYPICAL, SPREAD))

    whole = integrate.quad(density, TYPICAL - 9 * SPREAD, LEAST, points=[TYPICAL])[0]
    return math.log(whole) - float(stats.norm.logcdf(LEAST, TYPICAL, SPREAD))


def test_evidence_of_a_pattern_is_the_integral_over_its_losses() -> None:
    """One wheel exactly (its spread is SPREAD and ALIKE together); more by the formula with dense matrices."""
    rng = np.random.default_rng(5)
    root = rng.standard_normal((4, 4))
    information = 40.0 * root @ root.T
    score = information @ np.array([-0.15, 0.0, -0.2, 0.0])
    found = judge(score[None], information[None])
    values = []
    for pattern in PATTERNS:
        n = int(pattern.sum())
        v = SPREAD**2 * np.ones((n, n)) + ALIKE**2 * np.eye(n)
        u = np.linalg.solve(v, np.full(n, TYPICAL))
        k = information[np.ix_(pattern, pattern)] + np.linalg.inv(v)
        b = score[pattern] + u
        log_det = np.linalg.slogdet(v @ k)[1]
        values.append(0.5 * b @ np.linalg.solve(k, b) - 0.5 * u @ v @ u - 0.5 * log_det)
        after, before = np.linalg.solve(k, b).mean(), math.sqrt(v.mean())
        values[-1] += stats.norm.logcdf(LEAST, after, math.sqrt(np.linalg.inv(k).mean()))
        values[-1] -= stats.norm.logcdf(LEAST, TYPICAL, before)
    from estimators.itpms.patterns import PRIOR as prior

    total = np.logaddexp.reduce(np.array(values) + prior)
    assert found.statistic == pytest.approx(total, abs=1e-9)
    posterior = np.exp(np.array(values) + prior - total)
    assert found.low == pytest.approx(posterior @ PATTERNS, abs=1e-9)
    assert posterior.sum() == pytest.approx(1.0)
    one = np.zeros((4, 4))
    one[1, 1] = information[1, 1]
    assert _evidence(np.array([0, score[1], 0, 0]), one, [1]) == pytest.approx(values[1], abs=0.3)


def test_tyres_that_gained_or_lost_little_are_no_evidence() -> None:
    """However well it is known: what is below LEAST on the wrong side counts for nothing."""
    information = 1e5 * np.eye(4)
    for change in (0.1, 0.0, -0.03):
        d = np.array([change, change, 0.0, 0.0])
        assert judge((information @ d)[None], information[None]).statistic < 0.0
    d = np.array([-0.1, -0.1, 0.0, 0.0])
    assert judge((information @ d)[None], information[None]).statistic > 100.0


@pytest.mark.parametrize("low", [[0], [3], [0, 2], [1, 2, 3], [0, 1, 2, 3]])
def test_clear_losses_are_told_apart_and_measured(low: list[int]) -> None:
    d = np.zeros(4)
    d[low] = math.log(0.85)
    information = 3e4 * np.eye(4)
    found = judge((information @ d)[None], information[None])
    assert np.flatnonzero(found.best).tolist() == low
    assert found.certainty > 0.99
    assert found.change == pytest.approx(d, abs=0.01)
    assert found.statistic > TUNED.alone["fused"]


def test_no_information_is_no_evidence() -> None:
    found = judge(np.zeros((1, 4)), np.zeros((1, 4, 4)))
    assert found.statistic < 0.0
    change, std, low = summary(found, TUNED.alone["fused"], 0.0)
    assert np.abs(change).max() < 1e-3
    assert std == pytest.approx(PRIOR, rel=1e-3)
    assert low.max() < 1e-3


def _blocks(rng: np.random.Generator, speeds: np.ndarray) -> list[LearningBlock]:
    """Sound blocks: the antiphase mode rises by 0.1 % per m/s, slip 0.05, gyro offset 2 mrad/s."""
    found = []
    for v in speeds:
        level = np.concatenate(
            [np.full(4, math.log(86.0)) + 1e-3 * (v - 20.0), np.full(4, np.nan), [1e-3, -2e-3, 5e-4]]
        )
        gain, mu = -1.6 / v, float(rng.uniform(-0.1, 0.1))
        level[8:] += [0.002 * gain, 0.05 * mu, 0.0]
        std = np.array([0.02] * 8 + [2e-4] * 3)
        found.append(LearningBlock(float(v), level + std * rng.standard_normal(11), std**2, gain, mu, 0.0))
    return found


def test_calibration_finds_levels_and_slip_and_borrows_with_a_larger_std() -> None:
    rng = np.random.default_rng(6)
    known = learn(_blocks(rng, rng.uniform(16.0, 29.0, 300)))
    assert known is not None
    value = known.expected(22.0)
    std = np.sqrt(np.diag(known.unlearnt(0))).reshape(4, -1)[0]
    assert value[:4] == pytest.approx(math.log(86.0) + 2e-3, abs=6e-3)
    assert value[8:] == pytest.approx([1e-3, -2e-3, 5e-4], abs=2e-4)
    assert known.slip[0] == pytest.approx(0.05, abs=4.0 * known.slip[1])
    learnt = int(np.argmin(std))
    assert 16.0 < NODES[FAST_MODE.first + learnt] < 29.0
    assert std[learnt] < 3e-3
    for far in (std, known.std[0]):
        learnt = int(np.argmin(far))
        assert (np.diff(far[learnt:]) > 0.0).all()
        assert (np.diff(far[: learnt + 1]) < 0.0).all()
        assert max(far[0], far[-1]) > 1.5 * far[learnt]


def test_what_was_not_learnt_is_mostly_common_to_the_wheels() -> None:
    """At a speed far from those driven the mean of the wheels is unsure, one against the other three is not."""
    known = learn(_blocks(np.random.default_rng(6), np.full(300, 20.0)))
    assert known is not None
    weight = np.kron(np.eye(4), np.eye(FAST_MODE.count)[-1:])
    covariance = weight @ known.unlearnt(0) @ weight.T
    mean, contrast = np.full(4, 0.25), np.array([1.0, -1 / 3, -1 / 3, -1 / 3])
    common, each = 4.0 * np.square(FAST_MODE.step)  # four nodes above the one at 20 m/s
    assert mean @ covariance @ mean > 0.9 * (common + 0.25 * each)
    assert contrast @ covariance @ contrast < 4 / 3 * (each + 3e-3**2)


def test_information_takes_off_the_covariance_what_the_dense_formula_does() -> None:
    rng = np.random.default_rng(11)
    for mode in MODE_NODES:
        weight = rng.uniform(size=(mode.count + 3, mode.count))
        told = np.array([scale * weight.T @ weight for scale in (10.0, 1e3, 0.0, 1.0)])
        dense = np.zeros((4 * mode.count,) * 2)
        for w in range(4):
            dense[w * mode.count : (w + 1) * mode.count, w * mode.count : (w + 1) * mode.count] = told[w]
        expected = np.linalg.inv(np.linalg.inv(mode.spread()) + dense)
        assert remaining(mode.spread(), told) == pytest.approx(expected, abs=1e-9)


def test_tyres_warm_towards_their_balance_and_cool_while_standing() -> None:
    warming, v = Warming(2.0), 25.0
    values = [warming.step(number, v) for number in range(1000)]
    time = 2.0 * np.arange(1, 1001)
    assert values == pytest.approx(GAIN * v * TAU * (1.0 - np.exp(-time / TAU)), rel=2e-3)
    later = warming.step(1000 + 499, math.nan)
    assert later == pytest.approx(values[-1] * math.exp(-1000.0 / TAU))


def test_calibration_goes_there_and_back_and_refuses_nonsense() -> None:
    rng = np.random.default_rng(7)
    known = learn(_blocks(rng, rng.uniform(10.0, 35.0, 100)))
    assert known is not None
    document = known.document()
    assert Calibration.from_document(document).document() == document
    assert learn(_blocks(rng, np.full(20, 20.0))) is None
    for name in NAMES:
        with pytest.raises(ValueError, match=name):
            Calibration.from_document(document | {name: {"level": [0.0], "std": [0.0]}})
    negative = document[NAMES[0]] | {"node": [-1.0] * FAST_MODE.count}
    with pytest.raises(ValueError, match="below 0"):
        Calibration.from_document(document | {NAMES[0]: negative})
    with pytest.raises(ValueError, match="speeds"):
        Calibration.from_document({})
    with pytest.raises(ValueError, match="slip"):
        Calibration.from_document(document | {"slip": [math.nan, 1.0]})
    assert len(document["speeds"]) == len(NODES)


@pytest.mark.parametrize("wheel", range(4))
def test_a_smaller_wheel_shows_in_each_contrast_with_its_sign(wheel: int) -> None:
    e = np.zeros(4)
    e[wheel] = -2e-3
    collected = Contrasts(Car(), 20)
    for index in range(20):
        place = {"index": index, "time": 0.1 * index, "omega": 60.0 * np.exp(-e), "speed": 21.6, "roll": np.ones(4)}
        yaw = {"cos_steer": 1.0, "gyro": 0.0, "gyro_gain": 1.0, "stand_in": False}
        forces = {"traction": 0.02, "pull": np.zeros(2), "force": 0.0, "specific": 0.0}
        collected.add(Motion(**place, **yaw, **forces, readable=True, standing=False))
    block = collected.close()
    side, axle = (1.0, -1.0, 1.0, -1.0)[wheel], (1.0, 1.0, -1.0, -1.0)[wheel]
    expected = {LEFT_RIGHT: side, FRONT_REAR: axle, DIAGONAL: side * axle}
    for contrast, sign in expected.items():
        assert block.value[contrast] == pytest.approx(-1e-3 * sign, rel=1e-6)
    assert block.traction == pytest.approx(-0.02)
    assert len(collected.close().value) == 0  # nothing is left for the next block


@pytest.mark.parametrize("dead", range(4))
def test_a_dead_wheel_leaves_what_does_not_hold_it(dead: int) -> None:
    """Left against right of the other axle, front against rear of the other side; each as the radii say."""
    e = np.array([-1e-3, 2e-3, 5e-4, -3e-3])
    omega = 60.0 * np.exp(-e)
    omega[dead] = np.nan
    collected = Contrasts(Car(), 20)
    for index in range(20):
        place = {"index": index, "time": 0.1 * index, "omega": omega, "speed": 21.6, "roll": np.ones(4)}
        yaw = {"cos_steer": 1.0, "gyro": 0.0, "gyro_gain": 1.0, "stand_in": False}
        forces = {"traction": 0.02, "pull": np.zeros(2), "force": 0.0, "specific": 0.0}
        collected.add(Motion(**place, **yaw, **forces, readable=True, standing=False))
    block = collected.close()
    axle, side = ((2, 3), (0, 1))[dead // 2], ((1, 3), (0, 2))[dead % 2]
    assert block.value == pytest.approx([e[axle[0]] - e[axle[1]], e[side[0]] - e[side[1]]], rel=1e-6)
    assert np.isnan(block.contrasts).all()
    assert (block.mixing @ CONTRASTS)[:, dead] == pytest.approx([0.0, 0.0])


def test_sound_blocks_of_the_calibrated_car_raise_nothing_and_a_loss_does() -> None:
    """Monitor on simulated residuals: its statistic stays low, then names the wheel within seconds."""
    rng = np.random.default_rng(9)
    calibration = learn(_blocks(rng, rng.uniform(15.0, 30.0, 300)))
    assert calibration is not None
    car = Car()
    monitor, statistic = Monitor(car, calibration, "fused"), []
    for number in range(150):
        v, mu = 22.0 + 4.0 * math.sin(0.2 * number), 0.05 * math.sin(0.3 * number)
        d = np.array([0.0, math.log(0.85) if number >= 120 else 0.0, 0.0, 0.0])
        expected = calibration.expected(v)
        frequency = np.full((2, 4, 2), np.nan)
        frequency[0, :, 0] = expected[:4] + SENSITIVITY[0] * d + 0.02 * rng.standard_normal(4)
        frequency[0, :, 1] = 0.02
        contrasts = expected[8:] + car.radius_sensitivity * car.pressure * CONTRASTS @ d + [0, 0.05 * mu, 0]
        radius = RadiusBlock(contrasts + 2e-4 * rng.standard_normal(3), np.eye(3), -1.6 / v, mu, 0.0, v, math.nan)
        judgement = monitor.step(Block(number, frequency, radius, v))
        assert judgement is not None
        statistic.append(judgement.statistic)
        if number == 125:
            assert [w for w, low in zip(WHEELS, judgement.best, strict=True) if low] == ["fr"]
            assert monitor.onset(judgement) == pytest.approx(240.0, abs=4.0)
    assert max(statistic[:120]) < 0.6 * TUNED.alone["fused"]
    assert min(statistic[125:]) > TUNED.alone["fused"]

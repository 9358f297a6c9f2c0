"""What `axles` is told and does not take for a fact: masses and springs that are off, a load, a first block."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from estimators.axles.block import BINS, FREQUENCIES
from estimators.axles.calibration import Identified, from_document
from estimators.axles.likelihood import LOAD, STATES
from estimators.axles.parameters import LOAD_STD, NUMBERS, corrected
from estimators.axles.response import Axles, hub_responses
from estimators.axles.side import NOISE, Side
from estimators.quarter_car.road_shape import class_spectrum
from estimators.vertical_pressure.chain import Quarter
from models.identified import identified

WHEELBASE, SPEED, STEP, BLOCKS, CARS = 2.8, 18.0, 0.256, 60, 24
FRONT = Quarter(900.0, 50.0, 9.0, 30e3, 3.2e3, 0.13, 0.6, 0.005)
REAR = Quarter(700.0, 42.0, 9.0, 32e3, 3.2e3, 0.125, 0.5, 0.005)
AXLES = Axles(FRONT, REAR, 5.5e-4, WHEELBASE)
STIFFNESS, COHERENCY, PRIOR_STD, OFF = (225e3, 240e3), 0.98, 0.15, 0.058
ONES = np.ones(BINS)


def drawn(
    axles: Axles, rng: np.random.Generator, level: float, blocks: int, stiffness: tuple[float, float] = STIFFNESS
) -> NDArray[np.complex128]:
    """Independent blocks as the model says they are, (blocks, BINS, 2)."""
    H = np.empty((2, BINS), complex)
    hub_responses(axles, *stiffness, SPEED, 1.0, FREQUENCIES, H)
    S = level * np.einsum("in,jn->nij", H, H.conj())
    S[:, 1, 0] *= COHERENCY
    S[:, 0, 1] *= COHERENCY
    root = np.linalg.cholesky(S + NOISE * np.eye(2))
    white = (rng.standard_normal((blocks, BINS, 2)) + 1j * rng.standard_normal((blocks, BINS, 2))) / np.sqrt(2.0)
    return np.einsum("nij,bnj->bni", root, white)


def followed(told: Axles, told_std: float, Y: NDArray[np.complex128]) -> Side:
    flat = np.zeros((7, BINS))
    side = Side(
        Identified(told, flat, flat + 0j, 0.0, 0.0, told_std, 0.0), np.log([240e3, 240e3]), np.full(2, PRIOR_STD)
    )
    for block in Y:
        side.pass_time(STEP)
        side.take(block, SPEED, 1.0, ONES)
    return side


@cache
def errors(told_std: float) -> tuple[float, float]:
    """NEES of ln k and RMSE of it, after `BLOCKS`, of cars each of whose numbers is off by its own draw."""
    rng, square, found = np.random.default_rng(3), [], []
    for _ in range(CARS):
        told = corrected(AXLES, np.append(OFF * rng.standard_normal(NUMBERS - 1), 0.0), 0.0)
        true = np.log(240e3) + PRIOR_STD * rng.standard_normal(2)
        Y = drawn(AXLES, rng, class_spectrum("B"), BLOCKS, (float(np.exp(true[0])), float(np.exp(true[1]))))
        side = followed(told, told_std, Y)
        error = side.log_stiffness() - true
        square.append(error**2 / side.stiffness_variance())
        found.append(error)
    return float(np.mean(square)), float(np.sqrt(np.mean(np.square(found))))


def test_numbers_that_are_off_are_in_the_std_if_their_spread_is_declared() -> None:
    declared, believed = errors(OFF), errors(0.0)
    assert declared[0] == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / CARS))  # both wheels of a car go together
    assert believed[0] > 4.0
    assert declared[1] < 0.8 * believed[1]
    assert declared[1] < PRIOR_STD


def test_a_load_is_heard_and_is_not_stiffness() -> None:
    """A load on the body takes the same from every inverse mass; half of it at least is told from stiffness."""
    x = LOAD_STD
    loaded = corrected(AXLES, np.append(np.zeros(NUMBERS - 1), x), 0.0)
    for found, wanted in (
        (1.0 / loaded.front.sprung_mass, 1.0 / (900.0 * np.exp(x))),
        (1.0 / loaded.rear.sprung_mass, 1.0 / 700.0 - (1.0 - np.exp(-x)) / 900.0),
        (loaded.coupling, 5.5e-4 - (1.0 - np.exp(-x)) / 900.0),
    ):
        assert found == pytest.approx(wanted, rel=1e-12)
    said = []
    for seed in range(6):
        Y = drawn(loaded, np.random.default_rng(seed), class_spectrum("B"), 4 * BLOCKS)
        side = followed(AXLES, 0.0, Y)
        said.append([side.load(), *(side.log_stiffness() - np.log(STIFFNESS))])
    mean = np.mean(said, axis=0)
    assert 0.5 * x < mean[0] < 1.3 * x
    assert np.abs(mean[1:]).max() < 0.03


def test_what_pressure_makes_of_stiffness_is_less_sure_than_stiffness_only_by_the_load() -> None:
    flat = np.zeros((7, BINS))
    side = Side(Identified(AXLES, flat, flat + 0j, 0.0, 0.0, 0.0, 0.0), np.log([240e3, 240e3]), np.full(2, 0.1), 0.4)
    assert side.stiffness_variance() == pytest.approx(0.1**2 + (0.4 * LOAD_STD) ** 2)
    assert side.unloaded_variance() == pytest.approx(np.full(2, 0.1**2))
    assert side.P[LOAD, LOAD] == pytest.approx(LOAD_STD**2)
    assert np.linalg.eigvalsh(side.P).min() > 0.0
    assert side.theta.shape == (STATES,)


def test_a_first_block_and_one_on_another_road_say_nothing_of_a_loss() -> None:
    """Linearised on class B, a block of class D at the prior's stiffness tells of differences of some hundred per
    cent."""
    rng = np.random.default_rng(5)
    flat = np.zeros((7, BINS))
    side = Side(Identified(AXLES, flat, flat + 0j, 0.0, 0.0, 0.0, 0.0), np.log([240e3, 240e3]), np.full(2, PRIOR_STD))
    level, variances = class_spectrum("D"), []
    for block in drawn(AXLES, rng, level, 30):
        side.pass_time(STEP)
        variances.append(side.take(block, SPEED, 1.0, ONES).difference[1])
    assert variances[0] == np.inf
    assert np.isfinite(variances[8:]).all()
    side.theta[2] -= np.log(16.0)  # as after a change of road
    side.P[2, 2] += 1.0
    side.pass_time(STEP)
    assert side.take(drawn(AXLES, rng, level, 1)[0], SPEED, 1.0, ONES).difference[1] == np.inf


def test_spreads_are_numbers_of_the_document() -> None:
    document = dict(identified()["axles"])
    known = from_document(document | {"told_std": 0.05, "law_std": 0.1})
    assert (known.told_std, known.law_std) == (0.05, 0.1)
    silent = from_document({name: value for name, value in document.items() if name not in ("told_std", "law_std")})
    assert (silent.told_std, silent.law_std) == (0.0, 0.0)
    for name, value in (("told_std", -0.1), ("law_std", 1.0), ("told_std", "x"), ("law_std", float("nan"))):
        with pytest.raises(ValueError, match=f"{name} is"):
            from_document(document | {name: value})

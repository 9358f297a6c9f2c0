"""Both axles' parameters and tables from drives at known pressures: maximum Whittle likelihood.

Ljung, System Identification, 2nd ed., ch. 7.4, in the frequency domain: each drive's mean spectral matrix S_d (BINS, 2,
2) of aligned blocks is compared with the model of `likelihood` at known stiffnesses,

    cost = mean over drives and bins of tr(S^-1 S_d) + ln det S

with the coherence that was measured, the drive's own road level, and its own shift delta (rolling radius changes with
pressure). In turns: the parameters of `SEARCHED` of both axles and the coupling, within bounds about the maker's; each
drive's delta from the slope of the phase; last the tables of `calibration`, bin by bin by least squares, which take
what is left over w tau and stiffness, the same at every road level: measured, a car's H do not depend on it. The
footprint's growth for softer tyres is searched too: pressures of 130 to 250 kPa tell it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from estimators.axles.block import BINS, FREQUENCIES, HOP, WINDOW, spectrum
from estimators.axles.calibration import REFERENCE, ROWS, Identified, basis
from estimators.axles.response import Axles, hub_responses
from estimators.axles.side import NOISE
from estimators.compiled import compiled

SEARCHED = ("sprung_mass", "unsprung_mass", "spring_rate", "damping", "footprint", "softer")
BOUNDS = (0.6, 0.15, 0.6, 0.6, 0.6, 0.6)  # of ln(parameter over the maker's)
COUPLING = 3.0  # over the maker's, at most
STIFFNESS_STD, DIFFERENCE_STD = 0.02, 0.005  # what is left on drives that were fitted, whole minutes
_ROUNDS, _REFINED = 4, 2
_STEP = 1e-4  # of the logarithms, for the gradient
_HIGHEST = 0.998  # coherence
_FREQUENCIES, _BINS, _NOISE = FREQUENCIES.copy(), BINS, NOISE


@dataclass(frozen=True, eq=False)
class KnownRoad:
    """matrix: mean of Y Y^H over a drive's blocks, (BINS, 2, 2); stiffness of front and rear by the tyre's law [N/m],
    (2,); speed [m/s]."""

    matrix: NDArray[np.complex128]
    stiffness: NDArray[np.float64]
    speed: float


def mean_matrix(sides: Sequence[NDArray[np.float64]]) -> NDArray[np.complex128]:
    """Mean of Y Y^H over all windows of aligned samples (n, 2) of each side. ValueError if there is none."""
    blocks = [spectrum(y[k - WINDOW : k]) for y in sides for k in range(WINDOW, len(y) + 1, HOP)]
    if not blocks:
        raise ValueError(f"identification needs sides of at least {WINDOW} aligned samples")
    Y = np.array(blocks)
    return np.asarray(np.einsum("nfi,nfj->fij", Y, Y.conj()) / len(Y))


@compiled
def drive_cost(axles, stiffness, speed, shape, shift, matrix, coherence, level):
    """Cost of one drive, and its road level G, found from near `level`."""
    H = np.empty((2, _BINS), np.complex128)
    hub_responses(axles, stiffness[0], stiffness[1], speed, 1.0, _FREQUENCIES, H)
    G, found = level, 0.0
    for turn in range(3):
        total, log_det = 0.0, 0.0
        for i in range(_BINS):
            hf = H[0, i] * shape[0, i]
            hr = H[1, i] * shape[1, i] * np.exp(-2j * np.pi * _FREQUENCIES[i] * shift / speed)
            a, b = G * abs(hf) ** 2 + _NOISE, G * abs(hr) ** 2 + _NOISE
            x = hr * np.conj(hf)
            x *= coherence[i] * np.sqrt(a * b) / abs(x)
            det = a * b - abs(x) ** 2
            total += (
                b * matrix[i, 0, 0].real + a * matrix[i, 1, 1].real - 2.0 * (np.conj(x) * matrix[i, 1, 0]).real
            ) / det
            log_det += np.log(det)
        found = (total + log_det) / _BINS
        if turn < 2:
            G *= total / (2.0 * _BINS)
    return found, G


class _Fit:
    """The drives, and what is being fitted to them."""

    def __init__(self, maker: Identified, roads: Sequence[KnownRoad]) -> None:
        self.maker, self.roads = maker, roads
        self.place = np.zeros(2 * len(SEARCHED) + 1)
        self.place[-1] = 1.0
        self.levels, self.shifts = np.full(len(roads), 4e-6), np.zeros(len(roads))
        cross = [road.matrix[:, 1, 0] for road in roads]
        powers = [np.sqrt((road.matrix[:, 0, 0] * road.matrix[:, 1, 1]).real) for road in roads]
        self.coherence = [np.minimum(np.abs(x) / p, _HIGHEST) for x, p in zip(cross, powers, strict=True)]
        self.basis = np.array([basis(_mean(road.stiffness), road.speed, maker.axles.wheelbase) for road in roads])
        self.level, self.ratio = np.zeros((ROWS, BINS)), np.zeros((ROWS, BINS), complex)

    def axles(self, place: NDArray[np.float64]) -> Axles:
        quarters = [
            quarter._replace(**{n: getattr(quarter, n) * float(np.exp(a)) for n, a in zip(SEARCHED, part, strict=True)})
            for quarter, part in zip(self.maker.axles[:2], np.split(place[:-1], 2), strict=True)
        ]
        return Axles(quarters[0], quarters[1], float(place[-1]) * self.maker.axles.coupling, self.maker.axles.wheelbase)

    def shapes(self) -> NDArray[np.complex128]:
        common = np.einsum("nbf,bf->nf", self.basis, self.level)
        return np.exp(np.stack([common + 0j, common + np.einsum("nbf,bf->nf", self.basis, self.ratio)], axis=1))

    def search(self) -> float:
        shapes = self.shapes()

        def cost(place: NDArray[np.float64]) -> float:
            axles, total = self.axles(place), 0.0
            for n, road in enumerate(self.roads):
                found, self.levels[n] = drive_cost(
                    axles, road.stiffness, road.speed, shapes[n], self.shifts[n], road.matrix, self.coherence[n],
                    self.levels[n],
                )  # fmt: skip
                total += found
            return total / len(self.roads)

        def gradient(place: NDArray[np.float64]) -> NDArray[np.float64]:
            steps = _STEP * np.eye(len(place))
            return np.array([(cost(place + e) - cost(place - e)) / (2.0 * _STEP) for e in steps])

        bounds = [(-b, b) for b in (*BOUNDS, *BOUNDS)] + [(0.0, COUPLING)]
        found = minimize(cost, self.place, jac=gradient, method="L-BFGS-B", bounds=bounds, options={"maxiter": 80})
        self.place = found.x
        return float(found.fun)

    def left(self) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
        """What the axles without tables leave of ln |H_f| and of ln H_r / H_f, (drives, BINS) each; sets the shifts."""
        axles, level, ratio = self.axles(self.place), [], []
        H = np.empty((2, BINS), np.complex128)
        for n, road in enumerate(self.roads):
            hub_responses(axles, road.stiffness[0], road.stiffness[1], road.speed, 1.0, _FREQUENCIES, H)
            clean = road.matrix - NOISE * np.eye(2)
            turned = clean[:, 1, 0] / np.abs(clean[:, 1, 0])  # |S_rf| would be the lower the less is common
            rest = np.log(np.sqrt((clean[:, 1, 1] / clean[:, 0, 0]).real) * turned * H[0] / H[1])
            weight = 1.0 / (1.0 - self.coherence[n] ** 2 + 3e-3)
            phase = (rest - np.einsum("bf,bf->f", self.basis[n], self.ratio)).imag
            slope = float((weight * FREQUENCIES * phase).sum() / (weight * FREQUENCIES**2).sum())
            self.shifts[n] = -slope * road.speed / (2.0 * np.pi)
            ratio.append(rest - 1j * slope * FREQUENCIES)
            level.append(0.5 * np.log(clean[:, 0, 0].real / np.abs(H[0]) ** 2 / self.levels[n]))
        return np.array(level), np.array(ratio)

    def tables(self) -> None:
        level, ratio = self.left()
        for i in range(BINS):
            self.level[:, i] = np.linalg.lstsq(self.basis[:, :, i], level[:, i], rcond=None)[0]
            self.ratio[:, i] = np.linalg.lstsq(self.basis[:, :, i].astype(complex), ratio[:, i], rcond=None)[0]


def _mean(stiffness: NDArray[np.float64]) -> float:
    """m of `calibration`."""
    return float(np.log(stiffness / REFERENCE).mean())


def identify(maker: Identified, roads: Sequence[KnownRoad]) -> Identified:
    """ValueError for too few drives to fit tables to."""
    if len(roads) < 12:
        raise ValueError(f"identification needs at least 12 drives at several speeds and pressures, got {len(roads)}")
    fit = _Fit(maker, roads)
    for _ in range(_ROUNDS):
        fit.search()
        fit.left()
    for _ in range(_REFINED):
        fit.tables()
        fit.search()
    fit.tables()
    return Identified(fit.axles(fit.place), fit.level, fit.ratio, STIFFNESS_STD, DIFFERENCE_STD, 0.0, 0.0)

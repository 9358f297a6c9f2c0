"""How well a block fits, as score and Fisher information of what is not known of one side of the car.

Aligned front and rear spectra Y = (Y_f, Y_r) of a window are complex Gaussian with the covariance (Whittle, Arkiv for
Matematik 2, 1953)

    S = G [ |H_f|^2            c H_f H_r^* e^(i phi) ] + N 1,     phi = 2 pi f delta / v,    c = (1 - e^nu) gamma
          [ c H_r H_f^* e^(-i phi)           |H_r|^2 ]

G: the road's spectrum over that of slope -2 (`quarter_car.roughness`: level lambda, w_l of its long waves, w_s of its
short ones); N: the sensors' noise; delta [m]: how much later than a wheelbase the rear wheel is there; 1 - e^nu: the
coherency that is left beside the known loss gamma of off-tracking (`off_tracking`), nu for each of `BANDS`. G is common
to both, so that the road's level and shape fall out of H_r / H_f as far as c is near 1; where c is 0, what is left are
two wheels that know each other's road. theta = (ln k_f, ln k_r, ln lambda, delta, w_l, w_s, nu_1 ... nu_n, eta), eta:
what was told of the axles and may be wrong, and the load (`parameters`):

    score_i = share tr(S^-1 dS_i S^-1 (Y Y^H - S)),    J_ij = share tr(S^-1 dS_i S^-1 dS_j)
"""

from __future__ import annotations

import numpy as np

from estimators.axles.block import BINS, FREQUENCIES, SHARE
from estimators.axles.calibration import REFERENCE
from estimators.axles.parameters import NUMBERS, corrected
from estimators.axles.response import hub_responses
from estimators.compiled import compiled, inlined
from estimators.quarter_car.roughness import BREAK, WAVINESS
from estimators.quarter_car.roughness import REFERENCE as REFERENCE_WAVE

FRONT, REAR, LEVEL, SHIFT, LONG, SHORT, LOSS = range(7)
EDGES = (6.0, 11.0, 16.0)  # Hz, between the bands of nu
BANDS = len(EDGES) + 1
CHANGING = LOSS + BANDS  # states that a drive may change; behind them eta, which it does not
STATES = CHANGING + NUMBERS
LOAD = STATES - 1
SLOPES = 2 + NUMBERS + 1  # of ln H: by both ln k, eta and delta
BAND = np.searchsorted(np.array(EDGES), FREQUENCIES)
_REFERENCE = float(np.log(REFERENCE))
_STEP = 1e-3  # of ln k, in the central differences
_SMALL = 1e-5  # of eta and delta, ahead
_FREQUENCIES = FREQUENCIES.copy()
_BINS, _SHARE, _LOSS, _CHANGING, _NUMBERS = BINS, SHARE, LOSS, CHANGING, NUMBERS
_BREAK, _FROM, _ISO = float(BREAK), float(REFERENCE_WAVE), float(WAVINESS)


@compiled
def expect(told, theta, speed, stretch, shape, bend, H, slope):
    """H (2, BINS) at theta, and d ln H by ln k, eta and delta, slope (SLOPES, 2, BINS) with the hub second; shape, bend
    (2, BINS): the identified correction, see `calibration`. What the body passes on is delta off a wheelbase, too."""
    eta = theta[_CHANGING:].copy()
    axles = corrected(told, eta, theta[3])
    kf, kr = np.exp(theta[0]), np.exp(theta[1])
    ahead = np.exp(_STEP)
    up, down = np.empty((2, _BINS), np.complex128), np.empty((2, _BINS), np.complex128)
    hub_responses(axles, kf, kr, speed, stretch, _FREQUENCIES, H)
    for p in range(2):
        if p == 0:
            hub_responses(axles, kf * ahead, kr, speed, stretch, _FREQUENCIES, up)
            hub_responses(axles, kf / ahead, kr, speed, stretch, _FREQUENCIES, down)
        else:
            hub_responses(axles, kf, kr * ahead, speed, stretch, _FREQUENCIES, up)
            hub_responses(axles, kf, kr / ahead, speed, stretch, _FREQUENCIES, down)
        for hub in range(2):
            for i in range(_BINS):
                slope[p, hub, i] = (up[hub, i] - down[hub, i]) / (2.0 * _STEP * H[hub, i])
                slope[p, hub, i] += 0.5 * bend[hub, i]
    for j in range(_NUMBERS + 1):
        shift = theta[3]
        if j < _NUMBERS:
            eta[j] += _SMALL
        else:
            shift += _SMALL
        hub_responses(corrected(told, eta, shift), kf, kr, speed, stretch, _FREQUENCIES, up)
        if j < _NUMBERS:
            eta[j] -= _SMALL
        for hub in range(2):
            for i in range(_BINS):
                slope[2 + j, hub, i] = np.log(up[hub, i] / H[hub, i]) / _SMALL
    mean = 0.5 * (theta[0] + theta[1]) - _REFERENCE
    for hub in range(2):
        for i in range(_BINS):
            H[hub, i] *= shape[hub, i] * np.exp(bend[hub, i] * mean)


@inlined
def road_exponents(frequency, speed):
    """What w_l and w_s of slope -2 are multiplied by in -ln G, at a frequency [Hz] and speed [m/s]."""
    wave = 2.0 * np.pi * frequency / speed
    return np.log(min(wave / _BREAK, 1.0)), np.log(max(wave, _BREAK) / _FROM)


@compiled
def score_block(Y, H, slope, theta, speed, gamma, noise, band, score, J):
    """Score (STATES,) and information (STATES, STATES) of Y (BINS, 2), both overwritten; -log-likelihood. noise: N."""
    score[:] = 0.0
    J[:] = 0.0
    n = _LOSS + 1 + _NUMBERS
    cost = 0.0
    place = np.arange(n)
    place[_LOSS + 1 :] += _CHANGING - _LOSS - 1
    da, db, dx = np.zeros(n), np.zeros(n), np.zeros(n, np.complex128)
    u00, u11 = np.zeros(n, np.complex128), np.zeros(n, np.complex128)
    u01, u10 = np.zeros(n, np.complex128), np.zeros(n, np.complex128)
    for i in range(_BINS):
        below, over = road_exponents(_FREQUENCIES[i], speed)
        G = np.exp(theta[2] - (theta[4] - _ISO) * below - (theta[5] - _ISO) * over)
        lost = np.exp(theta[_LOSS + band[i]])
        c = (1.0 - lost) * gamma[i]
        turn = 2.0 * np.pi * _FREQUENCIES[i] / speed
        hf, hr = H[0, i], H[1, i]
        af, ar = G * (hf * np.conj(hf)).real, G * (hr * np.conj(hr)).real
        a, b = af + noise, ar + noise
        x = G * c * hr * np.conj(hf) * np.exp(-1j * turn * theta[3])  # S[rear, front]
        det = a * b - (x * np.conj(x)).real
        i00, i11, i10 = b / det, a / det, -x / det
        i01 = np.conj(i10)
        for p in range(2):
            at_front, at_rear = slope[p, 0, i], slope[p, 1, i]
            da[p], db[p], dx[p] = 2.0 * at_front.real * af, 2.0 * at_rear.real * ar, (np.conj(at_front) + at_rear) * x
        for j in range(_NUMBERS):
            at_front, at_rear, p = slope[2 + j, 0, i], slope[2 + j, 1, i], _LOSS + 1 + j
            da[p], db[p], dx[p] = 2.0 * at_front.real * af, 2.0 * at_rear.real * ar, (np.conj(at_front) + at_rear) * x
        da[2], db[2], dx[2] = af, ar, x
        at_front, at_rear = slope[2 + _NUMBERS, 0, i], slope[2 + _NUMBERS, 1, i]
        da[3], db[3] = 2.0 * at_front.real * af, 2.0 * at_rear.real * ar
        dx[3] = (np.conj(at_front) + at_rear - 1j * turn) * x
        da[4], db[4], dx[4] = -below * af, -below * ar, -below * x
        da[5], db[5], dx[5] = -over * af, -over * ar, -over * x
        da[_LOSS], db[_LOSS], dx[_LOSS] = 0.0, 0.0, -lost / (1.0 - lost) * x
        place[_LOSS] = _LOSS + band[i]
        yf, yr = Y[i, 0], Y[i, 1]
        sf = i00 * yf + i01 * yr  # S^-1 Y
        sr = i10 * yf + i11 * yr
        cost += _SHARE * ((np.conj(yf) * sf + np.conj(yr) * sr).real + np.log(det))
        for p in range(n):
            # U = S^-1 dS
            u00[p] = i00 * da[p] + i01 * dx[p]
            u01[p] = i00 * np.conj(dx[p]) + i01 * db[p]
            u10[p] = i10 * da[p] + i11 * dx[p]
            u11[p] = i10 * np.conj(dx[p]) + i11 * db[p]
            fits = da[p] * abs(sf) ** 2 + db[p] * abs(sr) ** 2 + 2.0 * (np.conj(sr) * dx[p] * sf).real
            score[place[p]] += _SHARE * (fits - (u00[p] + u11[p]).real)
        for p in range(n):
            for q in range(p + 1):
                trace = (u00[p] * u00[q] + u01[p] * u10[q] + u10[p] * u01[q] + u11[p] * u11[q]).real
                J[place[p], place[q]] += _SHARE * trace
                if p != q:
                    J[place[q], place[p]] += _SHARE * trace
    return cost

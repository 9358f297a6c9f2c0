"""Enveloping: what a rolling tyre makes of a short-wave road, by the tandem of two elliptic cams.

Schmeitz, A Semi-Empirical Three-Dimensional Model of the Pneumatic Tyre Rolling over Arbitrarily Uneven Road Surfaces
(2004); Pacejka, 3rd ed., ch. 10. Each cam is the lower edge of |x/a_e|^c + |z/b_e|^c = 1 and rests on the road: its
height is the largest of road(x + s) + b_e (|1 - |s/a_e|^c|^(1/c) - 1) over s, a morphological dilation. Two cams stand
l_s apart on the wheel's line; the effective plane's height is their mean, its forward slope their difference over l_s.

One line of cams a wheel: the road is taken as even across the tread, except for its lateral slope. A plain reference
(`envelope_reference`) stands beside the compiled kernel.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import inlined
from models.tyre_properties import TyreProperties

POINTS = 19  # samples along one cam; spacing 29 mm for the SUV, half an hfield cell of an ISO road
REACH = 0.48  # how far along a cam is looked, as a share of a_e: it has risen 0.22 b_e there, a kerb's height


class Cam(NamedTuple):
    """Cam shape: offsets along the wheel's line [m] and drop below its lowest point (<= 0) [m], shape (POINTS,)."""

    offset: NDArray[np.float64]
    drop: NDArray[np.float64]
    spacing_per_length: float  # l_s over the contact length 2a [-]
    lateral: float  # distance either side at which the lateral slope is read [m]


def cam(tyre: TyreProperties) -> Cam:
    """The cam of a tyre property set."""
    a_e, b_e, order = tyre.ellips_length * tyre.r0, tyre.ellips_height * tyre.r0, tyre.ellips_order
    offset = np.linspace(-REACH, REACH, POINTS) * a_e
    drop = b_e * ((1.0 - np.abs(offset / a_e) ** order) ** (1.0 / order) - 1.0)
    return Cam(offset, drop, tyre.ellips_shift, 0.35 * tyre.width)


@inlined
def _cam_height(heights, u, v, du, dv, offset, drop):
    """Cam height above the window's offset [m]; (u, v) node coordinates of its centre, (du, dv) nodes per metre along
    it."""
    best = -1e30
    rows, columns = heights.shape
    for k in range(offset.size):
        gu = u + du * offset[k]
        gv = v + dv * offset[k]
        iu = min(max(int(gu), 0), columns - 2)
        iv = min(max(int(gv), 0), rows - 2)
        fu = gu - iu
        fv = gv - iv
        low = heights[iv, iu] + fu * (heights[iv, iu + 1] - heights[iv, iu])
        high = heights[iv + 1, iu] + fu * (heights[iv + 1, iu + 1] - heights[iv + 1, iu])
        level = low + fv * (high - low) + drop[k]
        if level > best:
            best = level
    return best


@inlined
def effective_plane(heights, origin, shape, x, y, forward_x, forward_y, half_length):
    """Effective road under a wheel: height [m], slope along and across the wheel's line [-].

    heights: MuJoCo's hfield array (rows, columns); origin: x_min, y_min, z_offset, spacing [m]; shape: Cam;
    x, y: wheel centre [m]; forward: horizontal unit vector of the wheel's line; half_length: of the contact patch [m].
    """
    inverse = 1.0 / origin[3]
    half = shape.spacing_per_length * max(half_length, 0.02)
    u = (x - origin[0]) * inverse
    v = (y - origin[1]) * inverse
    du = forward_x * inverse
    dv = forward_y * inverse
    front = _cam_height(heights, u + du * half, v + dv * half, du, dv, shape.offset, shape.drop)
    back = _cam_height(heights, u - du * half, v - dv * half, du, dv, shape.offset, shape.drop)
    left = _level(heights, u - dv * shape.lateral, v + du * shape.lateral)
    right = _level(heights, u + dv * shape.lateral, v - du * shape.lateral)
    height = 0.5 * (front + back) + origin[2]
    return height, (front - back) / (2.0 * half), (left - right) / (2.0 * shape.lateral)


@inlined
def _level(heights, gu, gv):
    iu = min(max(int(gu), 0), heights.shape[1] - 2)
    iv = min(max(int(gv), 0), heights.shape[0] - 2)
    fu = gu - iu
    low = heights[iv, iu] + fu * (heights[iv, iu + 1] - heights[iv, iu])
    high = heights[iv + 1, iu] + fu * (heights[iv + 1, iu + 1] - heights[iv + 1, iu])
    return low + (gv - iv) * (high - low)


def envelope_reference(profile, spacing: float, tyre: TyreProperties, half_length: float):
    """Effective height and slope along a straight profile by plain dilation, as the kernel should give them.

    profile: heights [m] at a uniform spacing [m], shape (n,). Returns height and slope, shape (n,); the ends are NaN.
    """
    shape = cam(tyre)
    position = np.arange(len(profile)) * spacing
    half = shape.spacing_per_length * half_length

    def dilated(at: float) -> float:
        reach = at + shape.offset
        if reach[0] < 0.0 or reach[-1] > position[-1]:
            return math.nan
        return float(np.max(np.interp(reach, position, profile) + shape.drop))

    front = np.array([dilated(x + half) for x in position])
    back = np.array([dilated(x - half) for x in position])
    return 0.5 * (front + back), (front - back) / (2.0 * half)

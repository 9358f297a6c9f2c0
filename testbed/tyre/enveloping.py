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

REACH = 0.48  # how far along a cam is looked, as a share of a_e: it has risen 0.22 b_e there, a kerb's height
TABLE_STEP = 1e-3  # m between the tabulated drops of a cam
NEAR = np.array([0.0, 0.003, 0.007, 0.012, 0.018, 0.025])  # m to either side, where a cam bends within a road's cell


class Cam(NamedTuple):
    """Cam shape: drop below its lowest point (<= 0) [m] at multiples of TABLE_STEP from its middle, shape (n,)."""

    drop: NDArray[np.float64]
    near: NDArray[np.float64]  # offsets along the wheel's line that are looked at whatever the grid [m], shape (k,)
    reach: float  # how far along the wheel's line [m]
    spacing_per_length: float  # l_s over the contact length 2a [-]
    lateral: float  # distance either side at which the lateral slope is read [m]


def cam(tyre: TyreProperties) -> Cam:
    """The cam of a tyre property set."""
    a_e, b_e, order = tyre.ellips_length * tyre.r0, tyre.ellips_height * tyre.r0, tyre.ellips_order
    reach = REACH * a_e
    offset = TABLE_STEP * np.arange(math.ceil(reach / TABLE_STEP) + 2)
    drop = np.asarray(b_e * ((1.0 - (offset / a_e) ** order) ** (1.0 / order) - 1.0), np.float64)
    near = np.concatenate([-NEAR[:0:-1], NEAR])
    return Cam(drop, near, reach, tyre.ellips_shift, 0.35 * tyre.width)


@inlined
def _level(heights, gu, gv):
    iu = min(max(int(gu), 0), heights.shape[1] - 2)
    iv = min(max(int(gv), 0), heights.shape[0] - 2)
    fu = gu - iu
    low = heights[iv, iu] + fu * (heights[iv, iu + 1] - heights[iv, iu])
    high = heights[iv + 1, iu] + fu * (heights[iv + 1, iu + 1] - heights[iv + 1, iu])
    return low + (gv - iv) * (high - low)


@inlined
def _drop(shape, offset):
    """Drop of a cam at an offset from its middle within its reach [m]."""
    at = abs(offset) * (1.0 / TABLE_STEP)
    k = int(at)
    return shape.drop[k] + (at - k) * (shape.drop[k + 1] - shape.drop[k])


@inlined
def _cam_height(heights, u, v, du, dv, shape):
    """Cam height above the window's offset [m]; (u, v) node coordinates of its centre, (du, dv) nodes per metre along
    it.

    Between the grid's lines the road is straight and a cam bends little but near its middle, so the highest point lies
    on a line of nodes that the cam crosses, or near the middle.
    """
    best = -1e30
    for k in range(shape.near.size):
        offset = shape.near[k]
        best = max(best, _level(heights, u + du * offset, v + dv * offset) + _drop(shape, offset))
    along = abs(du) >= abs(dv)
    at, per_metre = (u, du) if along else (v, dv)
    span = abs(per_metre) * shape.reach
    last = (heights.shape[1] if along else heights.shape[0]) - 1
    for line in range(max(math.ceil(at - span), 0), min(math.floor(at + span), last) + 1):
        offset = (line - at) / per_metre
        if along:
            crossing = v + dv * offset
            j = min(max(int(crossing), 0), heights.shape[0] - 2)
            low, high = heights[j, line], heights[j + 1, line]
        else:
            crossing = u + du * offset
            j = min(max(int(crossing), 0), heights.shape[1] - 2)
            low, high = heights[line, j], heights[line, j + 1]
        best = max(best, low + (crossing - j) * (high - low) + _drop(shape, offset))
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
    front = _cam_height(heights, u + du * half, v + dv * half, du, dv, shape)
    back = _cam_height(heights, u - du * half, v - dv * half, du, dv, shape)
    left = _level(heights, u - dv * shape.lateral, v + du * shape.lateral)
    right = _level(heights, u + dv * shape.lateral, v - du * shape.lateral)
    height = 0.5 * (front + back) + origin[2]
    return height, (front - back) / (2.0 * half), (left - right) / (2.0 * shape.lateral)


def envelope_reference(profile, spacing: float, tyre: TyreProperties, half_length: float, points: int = 2001):
    """Effective height and slope along a straight profile by plain dilation with the super-ellipse's own equation.

    profile: heights [m] at a uniform spacing [m], shape (n,). points: along a cam. Returns height and slope, shape
    (n,); the ends are NaN.
    """
    a_e, b_e = tyre.ellips_length * tyre.r0, tyre.ellips_height * tyre.r0
    along = np.linspace(-REACH * a_e, REACH * a_e, points)
    edge = b_e * (1.0 - np.abs(along / a_e) ** tyre.ellips_order) ** (1.0 / tyre.ellips_order)
    position = np.arange(len(profile)) * spacing
    half = tyre.ellips_shift * half_length

    def dilated(at: float) -> float:
        reach = at + along
        if reach[0] < 0.0 or reach[-1] > position[-1]:
            return math.nan
        return float(np.max(np.interp(reach, position, profile) + edge)) - b_e

    front = np.array([dilated(x + half) for x in position])
    back = np.array([dilated(x - half) for x in position])
    return 0.5 * (front + back), (front - back) / (2.0 * half)

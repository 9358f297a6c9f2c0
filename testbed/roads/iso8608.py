"""Synthetic roads of ISO 8608: one class, a value between classes, or a sequence of them.

Gd(n) = Gd(n0) (n/n0)^-2 with n0 = 0.1 cycle/m and 0.011 <= n <= 10 cycle/m. Classes A to H are the geometric means 16
* 4^k e-6 m^3 (their limits lie a factor 2 either way). The surface is `random_field`'s: isotropic, two tracks
included.

A sequence changes its roughness abruptly at each place and keeps the height continuous for every y: each band b of
the field f is scaled by s = sqrt(Gd(n0)), and behind a change at x_c the left-over offset (s_before - s_after)
f_b(x_c, y) fades out by a smoothstep over that band's longest wave (1.6 m, 8 m and 91 m), so that neither a step nor
ruts remain. The last section goes on without end; before x = 0 the first one holds.

Between its 0.05 m nodes the road is bilinear, as its height field is, so a finer grid shows the same surface. A track
between two lines of nodes therefore loses short waves, as the mean of two lines does: at most 40 % of the spectrum in
the octave up to 10 cycle/m, 25 % in the one below it. A tread 0.2 m wide averages far more of them away.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from testbed.roads.bilinear import bilinear_grid, cell_and_fraction
from testbed.roads.random_field import BANDS, synthesise
from testbed.roads.road import ISO_SPACING, Array, Road, RoadKind, smoothstep
from testbed.roads.tile_kernel import add_tile

CLASSES = "ABCDEFGH"
FORM = "A..H | flat | gd=5e-5 (m^3 at 0.1 cycle/m) | in sequence A:200,D:300 (m) | gd=5e-5^2.5 (alone; slope -2.5)"
_GD_RANGE = (1e-8, 1.0)  # [m^3] from a polished floor to four times class H
_WAVINESS_RANGE = (1.0, 4.0)
_LONGEST_SECTION = 1e6  # [m]


def class_gd(letter: str) -> float:
    """Geometric-mean Gd(n0) [m^3] of a class A to H."""
    return 16e-6 * 4.0 ** CLASSES.index(letter)


@dataclass(frozen=True)
class Section:
    """From `start` [m] on, the roughness Gd(n0) [m^3]; 0 is flat."""

    start: float
    gd: float


def _level(text: str) -> float:
    word = text.strip()
    if word.lower() == "flat":
        return 0.0
    if len(word) == 1 and word.upper() in CLASSES:
        return class_gd(word.upper())
    if word.lower().startswith("gd="):
        gd = _number(word[3:])
        if _GD_RANGE[0] <= gd <= _GD_RANGE[1]:
            return gd
        raise ValueError(f"roughness '{word}': gd must be {_GD_RANGE[0]:g} to {_GD_RANGE[1]:g} m^3")
    raise ValueError(f"road class '{word}' is unknown; valid: {FORM}")


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def parse_waviness(spec: str) -> tuple[str, float]:
    """The spec without `^w`, and w: 2 where none is told. ValueError."""
    plain, told, word = spec.partition("^")
    if not told:
        return spec, 2.0
    waviness = _number(word)
    low, high = _WAVINESS_RANGE
    if "," in spec or not low <= waviness <= high:
        raise ValueError(
            f"road '{spec}': waviness must be {low:g} to {high:g}, of a road of one section, as gd=5e-5^2.5"
        )
    return plain, waviness


def parse_sections(spec: str) -> tuple[Section, ...]:
    """Sections of `C` or `A:200,D:300`; every one but the last needs its length in metres."""
    sections, start = [], 0.0
    words = spec.split(",")
    for k, word in enumerate(words):
        level, colon, metres = word.partition(":")
        sections.append(Section(start, _level(level)))
        if not colon and k == len(words) - 1:
            break
        length = _number(metres) if colon else math.nan
        if not ISO_SPACING <= length <= _LONGEST_SECTION:
            raise ValueError(
                f"road '{spec}': section '{word.strip()}' needs a length in metres, {ISO_SPACING:g} to "
                f"{_LONGEST_SECTION:g}, such as A:200"
            )
        start += round(length / ISO_SPACING) * ISO_SPACING
    return tuple(sections)


class IsoRoad(Road):
    """Sections of ISO 8608 roughness on one random field.

    sections: in order of x, the first at 0; seed: of the field; length: [m] over which the field must not repeat;
    waviness: how steeply the spectrum falls.
    """

    spacing = ISO_SPACING

    def __init__(
        self, name: str, sections: tuple[Section, ...], seed: int, length: float, waviness: float = 2.0
    ) -> None:
        self.name = name
        self.sections = sections
        seeds = [np.random.default_rng([seed, k]) for k in range(len(BANDS))]
        self._tiles = [synthesise(band, length, rng, waviness) for band, rng in zip(BANDS, seeds, strict=True)]
        self._starts = np.array([section.start for section in sections[1:]])
        self._scales = np.sqrt([section.gd for section in sections])

    def heights(self, x: Array, y: Array) -> Array:
        ix, tx = cell_and_fraction(np.asarray(x) / ISO_SPACING)
        iy, ty = cell_and_fraction(np.asarray(y) / ISO_SPACING)
        ni, nj = int(ix[-1] - ix[0]) + 1, int(iy[-1] - iy[0]) + 1
        nodes = self._nodes(int(ix[0]), ni + int(tx.any()), int(iy[0]), nj + int(ty.any()))
        if not tx.any() and not ty.any() and nodes.shape == (len(y), len(x)):
            return nodes
        return bilinear_grid(nodes, ix - ix[0], tx, iy - iy[0], ty)

    def _nodes(self, i0: int, ni: int, j0: int, nj: int) -> Array:
        """Heights (nj, ni) at the fine nodes from (i0, j0)."""
        x = np.arange(i0, i0 + ni) * ISO_SPACING
        scale = self._scales[np.searchsorted(self._starts, x + 1e-9, side="right")]
        z = np.zeros((nj, ni))
        for tile, band in zip(self._tiles, BANDS, strict=True):
            add_tile(z, tile.coefficients, tile.ratio, tile.shift, i0, j0, scale)
            for k, start in enumerate(self._starts):
                step = self._scales[k] - self._scales[k + 1]
                if not (x[-1] >= start > x[0] - band.longest_wave) or step == 0.0:
                    continue
                offset = np.zeros((nj, 1))
                i_start = round(start / ISO_SPACING)
                add_tile(offset, tile.coefficients, tile.ratio, tile.shift, i_start, j0, np.array([step]))
                remains = np.where(x >= start - 1e-9, 1.0 - smoothstep((x - start) / band.longest_wave), 0.0)
                z += offset * remains
        return z


def _recognises(spec: str) -> bool:
    first = spec.split(",")[0].partition(":")[0].strip().lower()
    whole = spec.strip().lower()
    if whole == "flat" or whole.endswith((".crg", ".txt")):
        return False
    return first.startswith("gd=") or first == "flat" or first.upper() in CLASSES or "," in spec or ":" in spec


def _build(spec: str, seed: int, length: float) -> IsoRoad:
    plain, waviness = parse_waviness(spec)
    return IsoRoad(spec, parse_sections(plain), seed, length, waviness)


KIND = RoadKind(
    form=FORM,
    example="A:200,D:300",
    recognises=_recognises,
    build=_build,
)

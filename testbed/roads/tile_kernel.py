"""Adds a block of a sheared periodic tile to a height array (compiled).

Node (i, j) of the plane, in units of the fine grid, lies at phase (i mod ratio, j mod ratio) of tile cell (i //
ratio, j // ratio). A tile of ratio 1 is read as it is; a coarser one is a cubic B-spline surface, interpolated first
along x in the few tile rows that the block touches, then along y. Row R of the endless tile is row R mod rows,
shifted by `shift` columns for every time round.
"""

from __future__ import annotations

import numpy as np

from estimators.compiled import compiled


@compiled
def _spline_weights(ratio):
    """Cubic B-spline weights of the four cells around each phase, (ratio, 4)."""
    weights = np.empty((ratio, 4))
    for p in range(ratio):
        t = p / ratio
        weights[p, 0] = (1.0 - t) ** 3 / 6.0
        weights[p, 1] = (3.0 * t**3 - 6.0 * t**2 + 4.0) / 6.0
        weights[p, 2] = (-3.0 * t**3 + 3.0 * t**2 + 3.0 * t + 1.0) / 6.0
        weights[p, 3] = t**3 / 6.0
    return weights


@compiled
def _read_row(tile, shift, row, first, out):
    """Copies len(out) cells of the endless tile's row, from column `first`."""
    rows, columns = tile.shape
    turns = row // rows
    source = tile[row - turns * rows]
    column = (first - shift * turns) % columns
    for i in range(len(out)):
        out[i] = source[column]
        column += 1
        if column == columns:
            column = 0


@compiled
def add_tile(out, tile, ratio, shift, i0, j0, gain):
    """out[j, i] += gain[i] * tile surface at the fine node (i0 + i, j0 + j).

    out: (nj, ni) float64 [m]; tile: float32 coefficients; gain: (ni,) [m per unit of the tile].
    """
    nj, ni = out.shape
    if ratio == 1:
        line = np.empty(ni)
        for j in range(nj):
            _read_row(tile, shift, j0 + j, i0, line)
            for i in range(ni):
                out[j, i] += gain[i] * line[i]
        return
    weights = _spline_weights(ratio)
    first_row = j0 // ratio - 1
    first_column = i0 // ratio - 1
    band = np.empty(((j0 + nj - 1) // ratio - first_row + 3, ni))
    cells = np.empty((i0 + ni - 1) // ratio - first_column + 3)
    for r in range(band.shape[0]):
        _read_row(tile, shift, first_row + r, first_column, cells)
        for i in range(ni):
            c = (i0 + i) // ratio - 1 - first_column
            w = weights[(i0 + i) % ratio]
            band[r, i] = w[0] * cells[c] + w[1] * cells[c + 1] + w[2] * cells[c + 2] + w[3] * cells[c + 3]
    for j in range(nj):
        r = (j0 + j) // ratio - 1 - first_row
        w = weights[(j0 + j) % ratio]
        a, b, c, d = band[r], band[r + 1], band[r + 2], band[r + 3]
        for i in range(ni):
            out[j, i] += gain[i] * (w[0] * a[i] + w[1] * b[i] + w[2] * c[i] + w[3] * d[i])

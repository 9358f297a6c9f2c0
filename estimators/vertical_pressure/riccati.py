"""A linear filter at rest: its steady gain, by doubling.

x(k+1) = A x(k) + w, y(k) = C x(k) + e, cov w = Q, cov e = R. The covariance of the prediction solves

    P = A P A' - A P C' (C P C' + R)^-1 C P A' + Q

and is the limit of the structure-preserving doubling algorithm (Chu, Fan, Lin, Wang, Int. J. Control 77, 2004): A_0 =
A', G_0 = C' R^-1 C, H_0 = Q, W = I + G H, then A <- A W^-1 A, G <- G + A W^-1 G A', H <- H + A' H W^-1 A, each step of
which stands for twice as many samples. Gain K = P C' S^-1, S = C P C' + R: x <- x + K e; then x <- A x.
"""

from __future__ import annotations

import numpy as np

from estimators.compiled import compiled

_MOST = 40  # doublings: 2^40 samples
_ENOUGH = 1e-12  # relative change of P's trace


@compiled
def steady_prediction(A, C, Q, R):
    """P, shape (n, n); A (n, n), C (m, n), Q (n, n), R (m, m)."""
    n = A.shape[0]
    a = A.T.copy()
    g = C.T @ np.linalg.inv(R) @ C
    h = Q.copy()
    identity = np.eye(n)
    for _ in range(_MOST):
        inverse = np.linalg.inv(identity + g @ h)
        a_inverse = a @ inverse
        grown = a.T @ (h @ (inverse @ a))
        g = g + a_inverse @ g @ a.T
        a = a_inverse @ a
        h = h + grown
        h = 0.5 * (h + h.T)
        g = 0.5 * (g + g.T)
        if np.trace(grown) <= _ENOUGH * np.trace(h):
            break
    return h


@compiled
def steady_filter(A, C, Q, R):
    """(K (n, m), S (m, m)) of the steady filter."""
    P = steady_prediction(A, C, Q, R)
    S = C @ P @ C.T + R
    return P @ C.T @ np.linalg.inv(S), S

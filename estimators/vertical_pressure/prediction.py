"""The best linear prediction of a sample from the `MEMORY` samples before it, and how wrong it will be.

For a stationary process of autocovariance r the predictor's error filter a (a_0 = 1) and error variance S solve

    sum_j a_j r(|i - j|) = S if i = 0, else 0,    i = 0 ... MEMORY

(Yule-Walker), by the Levinson-Durbin recursion (Durbin, Rev. Int. Stat. Inst. 28, 1960). nu(t) = sum_j a_j y(t - j)
is the innovation of the linear system behind r: that of its steady Kalman filter (`innovations`), for a memory long
enough, but with no state, and with exactly the variance that is stated for a memory that is not. A second is enough: S
is within 1.5 % of the Kalman filter's, and what it misses, waves of seconds, tells nothing of a tyre.
"""

from __future__ import annotations

import numpy as np

from estimators.compiled import compiled

MEMORY = 64  # decimated samples: 1 s


@compiled
def predictors(covariance, white, scaled, log_variance):
    """Error filters over their error's standard deviation, scaled (n, m, MEMORY + 1), and ln of its variance,
    log_variance (n, m), of n autocovariances (n, MEMORY + 1), each with m white variances (m,) added; both outputs are
    written."""
    n, last = covariance.shape
    a, other, r = np.empty(last), np.empty(last), np.empty(last)
    for i in range(n):
        for j in range(len(white)):
            r[:] = covariance[i]
            r[0] += white[j]
            a[:] = 0.0
            a[0] = 1.0
            S = r[0]
            for order in range(1, last):
                total = 0.0
                for k in range(order):
                    total += a[k] * r[order - k]
                reflection = -total / S
                for k in range(order + 1):
                    other[k] = a[k] + reflection * a[order - k]
                a[: order + 1] = other[: order + 1]
                S *= 1.0 - reflection * reflection
            log_variance[i, j] = np.log(S)
            scaled[i, j] = a / np.sqrt(S)

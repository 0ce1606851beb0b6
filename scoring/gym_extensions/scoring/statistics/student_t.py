"""Student's t distribution, from ``scipy.special``.

Degrees of freedom (``df``) are any number of at least 1, integer or not. Relative errors measured against
40-digit arithmetic for 1 to 300 degrees of freedom: quantiles 1e-15, p values 2e-14.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import nctdtr, stdtr, stdtrit


def quantile(probability: float, df: float) -> float:
    """The t with P(T ≤ t) = ``probability``."""
    return float(stdtrit(df, probability))


def two_sided_p(t: ArrayLike, df: ArrayLike) -> NDArray[np.float64]:
    """P(|T| ≥ |t|), element by element. It is 0 for an infinite t."""
    p_values: NDArray[np.float64] = 2 * stdtr(df, -np.abs(t))
    return p_values


def critical_value(alpha: float, df: float) -> float:
    """The t with a two-sided p value of ``alpha``, precise for the smallest ``alpha``, too."""
    return -quantile(alpha / 2, df)


def power(shift: float, critical: float, df: float) -> float:
    """The probability that a test rejects in the direction of a true difference.

    P(T > ``critical``) for T noncentral with noncentrality ``shift``: the difference in standard errors, not
    negative. A rejection in the wrong direction does not count. ``shift`` is limited to 2 · ``critical`` + 3,
    where the power exceeds .95 for any ``df``, because ``nctdtr`` returns NaN far beyond. The error is below
    1e-11 for ``df`` ≥ 4.
    """
    return 1.0 - float(nctdtr(df, min(shift, 2 * critical + 3), critical))

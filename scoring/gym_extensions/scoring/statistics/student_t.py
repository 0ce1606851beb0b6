"""Student's t distribution in small functions: p values, critical values, the power of a test.

What these give is compared with a level or counted in whole runs; it is never printed beyond three digits,
because the C library's logarithms differ in their last bits from machine to machine.
"""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Real = TypeVar("Real", float, NDArray[np.float64])

SMALLEST = 1e-300
PRECISION = 1e-15
TERMS = 500
SLICES = 400
HALVINGS = 44


def two_sided_p(t: float, freedom: float) -> float:
    """P(|T| ≥ |t|) for T of that many degrees of freedom: I_x(ν/2, 1/2) at x = ν / (ν + t²)."""
    if math.isinf(t):
        return 0.0
    return _incomplete_beta(freedom / 2, 0.5, freedom / (freedom + t * t))


def _incomplete_beta(a: float, b: float, x: float) -> float:
    """The regularised incomplete beta function I_x(a, b), by its continued fraction (DLMF 8.17.22)."""
    if x <= 0 or x >= 1:
        return 0.0 if x <= 0 else 1.0
    if x > (a + 1) / (a + b + 2):
        return 1.0 - _incomplete_beta(b, a, 1 - x)
    front = a * math.log(x) + b * math.log1p(-x) + math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b)
    return math.exp(front) * _fraction(a, b, x) / a


def coefficient(term: int, a: Real, b: float, x: Real) -> Real:
    """d of that term in the continued fraction of I_x(a, b); of columns, each element's (DLMF 8.17.23)."""
    m = term // 2
    if term % 2:
        return -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))
    return m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m))


def _fraction(a: float, b: float, x: float) -> float:
    """1 / (1 + d₁/(1 + d₂/(1 + …))) by Lentz's forward evaluation."""
    value, above, below = 1.0, 1.0, 0.0
    for term in range(1, TERMS):
        d = coefficient(term, a, b, x)
        below = 1 / (1 + d * below or SMALLEST)
        above = 1 + d / above or SMALLEST
        value *= above * below
        if abs(above * below - 1) < PRECISION:
            break
    return 1 / value


def critical(level: float, freedom: float) -> float:
    """The t whose two-sided p value is the level, by bisection."""
    low, high = 0.0, 2.0
    while two_sided_p(high, freedom) > level:
        low, high = high, high * 2
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        if two_sided_p(middle, freedom) > level:
            low = middle
        else:
            high = middle
    return (low + high) / 2


def power(shift: float, level_t: float, freedom: float) -> float:
    """P(|T| > t) for a noncentral T: the chance that a test with this critical value sees the shift.

    The integral over the estimated deviation (a scaled chi, ν degrees of freedom) of the normal tail beyond
    it, by Simpson's rule over eight standard deviations of the chi's density.
    """
    width = 8 / math.sqrt(2 * freedom)
    start, end = max(1e-9, 1 - width), 1 + width
    step = (end - start) / SLICES
    log_scale = math.log(2) + freedom / 2 * math.log(freedom / 2) - math.lgamma(freedom / 2)

    def density(u: float) -> float:
        return math.exp(log_scale + (freedom - 1) * math.log(u) - freedom / 2 * u * u)

    def tail(u: float) -> float:
        above = math.erfc((level_t * u - shift) / math.sqrt(2)) / 2
        return above + math.erfc((level_t * u + shift) / math.sqrt(2)) / 2

    points = (start + index * step for index in range(SLICES + 1))
    weights = (1 if index in (0, SLICES) else 4 if index % 2 else 2 for index in range(SLICES + 1))
    return math.fsum(w * density(u) * tail(u) for w, u in zip(weights, points, strict=True)) * step / 3

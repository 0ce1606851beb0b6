"""Running mean and standard deviation of observations, as pure functions of an immutable state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gym_extensions.baselines.agent import Array

CLIP = 10.0
"""Standardized observations are clipped to ±10 standard deviations, as by SB3's ``VecNormalize``."""
LEAST_DEVIATION = 1e-3
"""Smallest deviation of a policy's observations, so that rounding errors of constant ones stay small."""
EPSILON = 1e-8
"""Added to the standard deviation."""


@dataclass(frozen=True)
class Moments:
    """Number of observations so far, their mean (o,) and their sum of squared deviations (o,), float64."""

    count: float
    mean: Array
    squares: Array


def no_moments(width: int) -> Moments:
    """The moments of no observations."""
    return Moments(0.0, np.zeros(width), np.zeros(width))


def merge(moments: Moments, observations: Array) -> Moments:
    """The moments with the observations (n, o) added, by the formula of Chan, Golub and LeVeque (1979)."""
    new = observations.astype(np.float64)
    count, seen = len(new), moments.count
    new_mean = new.mean(axis=0)
    gap = new_mean - moments.mean
    inside = np.square(new - new_mean).sum(axis=0)
    between = gap**2 * seen * count / (seen + count)
    mean = moments.mean + gap * count / (seen + count)
    return Moments(seen + count, mean, moments.squares + (inside + between))


def scale(moments: Moments, least: float = LEAST_DEVIATION) -> Array:
    """What observations are divided by (o,): the standard deviation, at least ``least``."""
    deviation = np.sqrt(moments.squares / max(moments.count, 1.0))
    positive: Array = np.maximum(deviation, least) + EPSILON
    return positive


def standardize(moments: Moments, observations: Array, least: float = LEAST_DEVIATION) -> Array:
    """Observations (n, o) minus the mean, over the standard deviation, clipped; float32."""
    return np.clip((observations - moments.mean) / scale(moments, least), -CLIP, CLIP).astype(np.float32)


def network_inputs(moments: Moments, observations: Array) -> Array:
    """Standardized observations (n, o); raw ones while the moments are those of no observations."""
    return standardize(moments, observations) if moments.count else observations

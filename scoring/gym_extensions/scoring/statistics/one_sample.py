"""The one-sample t test: whether a mean over runs differs from zero."""

from __future__ import annotations

import math

from gym_extensions.scoring.statistics.intervals import Summary
from gym_extensions.scoring.statistics.student_t import two_sided_p


def zero_mean_p(estimate: Summary) -> float:
    """The two-sided p value of a mean of zero. Without variance it is 1 for a mean of zero and 0 for another.

    Args:
        estimate: of at least two runs. The differences of paired runs give the paired t test.
    """
    if estimate.mean == 0 or estimate.squared_error == 0:
        return float(estimate.mean == 0)
    return float(two_sided_p(estimate.mean / math.sqrt(estimate.squared_error), estimate.df))

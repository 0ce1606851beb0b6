"""Metrics of continual learning: arrays in, numbers out, whatever produced them.

``compute`` computes every metric from a matrix of returns. The formulas are those of the scorecards
(docs/metrics.md). Other implementations can be tested with the conformance kit, the JSON files in the folder
``conformance`` of this package.

>>> from gym_extensions import metrics
>>> values = metrics.compute([[1.0, 0.0], [0.5, 1.0]])  # row: tasks trained so far; column: task
>>> values["forgetting"].mean
0.5
"""

from gym_extensions.metrics.compute import FORMULAS, compute
from gym_extensions.metrics.formulas import Profile, area, iqm, probability_of_improvement, profile
from gym_extensions.metrics.statistics import Interval, difference, interval
from gym_extensions.metrics.values import MetricValue

__all__ = [
    "FORMULAS",
    "Interval",
    "MetricValue",
    "Profile",
    "area",
    "compute",
    "difference",
    "interval",
    "iqm",
    "probability_of_improvement",
    "profile",
]

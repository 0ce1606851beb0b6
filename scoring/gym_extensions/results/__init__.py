"""Results as pandas data frames and plots: episodes, training curves, metrics and boards of submissions.

``docs/results.md`` shows an example. Importing this package loads pandas, and neither a simulator nor torch.

>>> from gym_extensions import results
>>> episodes = results.episodes("submissions/trpo-2017")
>>> means = episodes.groupby(["group", "run", "stage", "task"])["return"].mean()
"""

from gym_extensions.results.frames import curves, episodes, evaluations
from gym_extensions.results.plots import plot_board, plot_curves, plot_matrix, plot_retention
from gym_extensions.results.policies import forgetting_predictors, network_changes, policies
from gym_extensions.results.scores import (
    board,
    core,
    core_pairs,
    core_variants,
    landscapes,
    metrics,
    order_effects,
    score_matrix,
    scores,
)

__all__ = [
    "board",
    "core",
    "core_pairs",
    "core_variants",
    "curves",
    "episodes",
    "evaluations",
    "forgetting_predictors",
    "landscapes",
    "metrics",
    "network_changes",
    "order_effects",
    "plot_board",
    "plot_curves",
    "plot_matrix",
    "plot_retention",
    "policies",
    "score_matrix",
    "scores",
]

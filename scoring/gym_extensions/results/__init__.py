"""Results as pandas data frames and plots: episodes, training curves, metrics and boards of submissions.

``docs/results.md`` shows an example. Importing this package loads pandas, and neither a simulator nor torch.

>>> from gym_extensions import results
>>> episodes = results.episodes("submissions/trpo-2017")
>>> episodes.groupby(["group", "run", "stage", "task"])["return"].mean()
"""

from gym_extensions.results.board_plot import plot_board
from gym_extensions.results.evaluations import evaluations
from gym_extensions.results.plots import plot_curves, plot_matrix, plot_retention
from gym_extensions.results.rollouts import curves, episodes
from gym_extensions.results.scores import board, metrics
from gym_extensions.results.unfinished import unfinished_curves

__all__ = [
    "board",
    "curves",
    "episodes",
    "evaluations",
    "metrics",
    "plot_board",
    "plot_curves",
    "plot_matrix",
    "plot_retention",
    "unfinished_curves",
]

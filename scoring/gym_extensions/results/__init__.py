"""Results as pandas data frames: episodes, training curves, metrics and boards of submissions.

``docs/results.md`` shows an example. Importing this package loads pandas, and neither a simulator nor torch.

>>> from gym_extensions import results
>>> episodes = results.episodes("submissions/trpo-2017")
>>> episodes.groupby(["group", "run", "stage", "task"])["return"].mean()
"""

from gym_extensions.results.rollouts import curves, episodes
from gym_extensions.results.scores import board, metrics

__all__ = ["board", "curves", "episodes", "metrics"]

"""Results as pandas data frames: episodes, training curves, metrics and boards of submissions.

>>> from gym_extensions import results
>>> episodes = results.episodes("submissions/trpo")
>>> episodes.groupby(["group", "run", "stage", "task"])["return"].mean()
"""

from gym_extensions.results.rollouts import curves, episodes

__all__ = ["curves", "episodes"]

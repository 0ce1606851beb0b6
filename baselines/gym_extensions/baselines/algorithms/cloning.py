"""TRPO that clones its earlier policies on stored states (Rusu et al. 2016; Wolczyk et al. 2022)."""

from __future__ import annotations

from gym_extensions.baselines.algorithms.continual import settings as table
from gym_extensions.baselines.algorithms.continual.clones import Clones
from gym_extensions.baselines.algorithms.continual.regularized import RegularizedTrpo
from gym_extensions.baselines.algorithms.continual.regularizer import Regularizer


class Cloning(RegularizedTrpo):
    """The agent ``cloning``."""

    name, title = "cloning", "TRPO + behavioral cloning"
    description = "The reference agent with a penalty on KL(old ‖ new policy) in stored states of each task."
    published_coefficient = table.CLONING

    def _new_regularizer(self, coefficient: float) -> Regularizer:
        return Clones(coefficient, table.STATES_PER_TASK)


make = Cloning

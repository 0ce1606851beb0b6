"""Observations of the tasks, on which networks are compared without a simulator.

Policies of different runs and methods visit different states. To compare their networks, they all see the
same observations: of every task those that :func:`states` returns. ``python -m tools.environments`` adds
those of new tasks; what is published never changes, and other observations get another version.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

VERSION = 1
PATH = Path(__file__).with_name(f"states-{VERSION}.npz")


def states(task_ids: Sequence[str]) -> list[NDArray[np.float32]] | None:
    """The observations of each task, (128, o); None if one has none, as custom tasks and those of images.

    One half comes from 8 episodes of the task's expert, the other from 8 episodes of uniformly random actions
    (all from these where there is no expert). The seeds are ``evaluation_seed(task_id, behavior, episode)``,
    where ``behavior`` is ``states of the expert`` or ``states of random actions``. Of each episode there are
    8 observations at equal distances, the first after the reset, rounded to float16.
    """
    with np.load(PATH) as file:
        known = set(file.files)
        return [file[task].astype(np.float32) for task in task_ids] if known.issuperset(task_ids) else None

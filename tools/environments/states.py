"""Records the observations on which networks are compared (``gym_extensions.catalog.states``)."""

from contextlib import closing
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog import descriptions
from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.protocol import evaluation_seed
from gym_extensions.catalog.states import PATH
from gym_extensions.catalog.tasks import Task
from gym_extensions.envs import make_vec, rollout
from gym_extensions.files import write_bytes
from gym_extensions.references import experts
from gym_extensions.submissions.policies.files import npz_bytes

EXPERT, RANDOM = "states of the expert", "states of random actions"
EPISODES, PER_EPISODE = 8, 8
"""Episodes under each behavior, and observations of each episode."""


def record(task: Task) -> NDArray[Any]:
    """The observations of a task, (128, …), half of them of its expert if it has one."""
    has_expert = task.bare_name in experts.names()
    first = _observations(task, EXPERT if has_expert else RANDOM, 0)
    return np.concatenate([first, _observations(task, RANDOM, 0 if has_expert else EPISODES)])


def _observations(task: Task, behavior: str, start: int) -> NDArray[Any]:
    seeds = [evaluation_seed(task.id, behavior, start + episode) for episode in range(EPISODES)]
    rngs = [np.random.default_rng(seed) for seed in seeds]
    expert = experts.load(task) if behavior == EXPERT else None
    seen: list[NDArray[Any]] = []

    def act(observations: NDArray[Any], *_: object) -> NDArray[Any]:
        seen.append(observations.copy())
        if expert is not None:
            return expert.act(observations)
        return np.stack([rng.uniform(space.low, space.high) for rng in rngs])

    with closing(make_vec(task, EPISODES)) as env:
        space: Any = env.single_action_space
        outcomes = rollout.run_episodes(env, seeds, act)
    steps = [np.linspace(0, each.length - 1, PER_EPISODE).round().astype(int) for each in outcomes]
    return np.concatenate([np.stack(seen)[at, episode] for episode, at in enumerate(steps)], dtype=np.float16)


def update() -> int:
    """Adds the observations of published tasks that have none and observe no images; returns their number."""
    known: dict[str, NDArray[Any]] = {}
    if PATH.exists():
        with np.load(PATH) as file:
            known |= file
    tasks = {task.id: task for group in GROUPS.values() for task in group.tasks}
    seen = {name for name, each in descriptions.descriptions().items() if each.observations}
    missing = [task for name, task in tasks.items() if name in seen and name not in known]
    if missing:
        known |= {task.id: record(task) for task in missing}
        write_bytes(PATH, npz_bytes(dict(sorted(known.items()))))
    return len(missing)

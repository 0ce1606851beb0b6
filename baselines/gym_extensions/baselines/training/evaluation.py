"""Evaluates agents on the tasks of a job with the prescribed seeds."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from statistics import fmean

import numpy as np

from gym_extensions.baselines.agent import (
    Agent,
    Array,
    Context,
    Resumable,
    TaskLabel,
    VectorEnv,
    action_function,
)
from gym_extensions.baselines.agent_spec import first_actions, require_agreement
from gym_extensions.baselines.generators import preserved_global_generators
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, evaluation_seed
from gym_extensions.catalog.tasks import Task
from gym_extensions.envs import make_vec
from gym_extensions.envs.rollout import Outcome, Watch, run_episodes
from gym_extensions.submissions.log import Episode
from gym_extensions.submissions.policies.files import AnyPolicy


def evaluate(
    agent: Agent,
    env: VectorEnv,
    seeds: Sequence[int],
    label: TaskLabel | None = None,
    watch: Watch | None = None,
) -> list[Outcome]:
    """Runs the first episode of every environment, of which there are ``len(seeds)``, with an agent.

    ``label`` is the task, only for an agent that asked for ``task_in_evaluation``. ``watch`` is called as by
    :func:`run_episodes`, whose outcomes are returned.
    """
    act = action_function(agent)
    return run_episodes(env, seeds, lambda seen, starts, _: act(seen, Context(starts, label)), watch=watch)


@dataclass
class Evaluator:
    """Evaluates on the tasks of a group; creates the environments of a task on first use and keeps them."""

    group: TaskGroup
    observes_task: bool = False  # whether the agent asked for ``task_in_evaluation``
    _envs: dict[tuple[str, int], VectorEnv] = field(default_factory=dict)

    def envs(self, task: Task, episodes: int = EVALUATION_EPISODES) -> VectorEnv:
        """One environment of the task per episode."""
        if (task.id, episodes) not in self._envs:
            self._envs[task.id, episodes] = make_vec(task, episodes)
        return self._envs[task.id, episodes]

    def evaluate(self, agent: Agent, stage: int, task: Task, policy: AnyPolicy | None) -> list[Episode]:
        """The episodes of the agent on a task. Raises ``BenchError`` if its policy acts in another way.

        If its policy is deterministic, the episodes are the policy's own, so that they can be repeated.
        """
        index, env = self.group.tasks.index(task), self.envs(task)
        seeds, label = self._seeds_and_label(task, EVALUATION_EPISODES)
        if policy is not None and policy.head == "deterministic":
            require_agreement(policy, env, seeds, first_actions(agent, env, seeds, label), index)
            policy.reset()
            outcomes = run_episodes(env, seeds, lambda seen, *_: policy.act(seen, None, index))
        else:
            first: list[Array] = []

            def remember(actions: Array | None) -> None:
                if actions is not None and not first:
                    first.append(np.array(actions))

            outcomes = evaluate(agent, env, seeds, label, remember)
            if policy is not None:
                require_agreement(policy, env, seeds, first[0], index)
        return [
            Episode(stage, task.id, episode, seed, *outcome)
            for episode, (seed, outcome) in enumerate(zip(seeds, outcomes, strict=True))
        ]

    def mean_return(self, agent: Agent, task: Task, episodes: int) -> float:
        """The mean return on a task over its first episodes."""
        seeds, label = self._seeds_and_label(task, episodes)
        outcomes = evaluate(agent, self.envs(task, episodes), seeds, label)
        return fmean(outcome.return_ for outcome in outcomes)

    def _seeds_and_label(self, task: Task, episodes: int) -> tuple[list[int], TaskLabel | None]:
        seeds = [evaluation_seed(self.group.id, task.id, episode) for episode in range(episodes)]
        label = TaskLabel(task.id, self.group.task_ids.index(task.id)) if self.observes_task else None
        return seeds, label

    def close(self) -> None:
        for env in self._envs.values():
            env.close()


@contextmanager
def acting_copy(agent: Agent, create: Callable[[], Agent], path: Path) -> Iterator[Agent]:
    """A copy of the agent that acts without an effect on its training; restores global random generators.

    An agent that cannot be saved acts itself, so that its generator for acting moves on. ``create`` makes an
    agent of the same kind; the file ``path`` is written and deleted.
    """
    with preserved_global_generators():
        acting = create() if isinstance(agent, Resumable) else agent
        if isinstance(agent, Resumable) and isinstance(acting, Resumable):
            try:
                agent.save(path)
                acting.load(path)
            finally:
                path.unlink(missing_ok=True)
        yield acting

"""Evaluates an agent on the tasks of a job, and stores the trace of every episode."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import fmean

from gym_extensions.atomic import write_bytes
from gym_extensions.baselines.agent import Agent, VectorEnv
from gym_extensions.baselines.context import TaskLabel
from gym_extensions.baselines.training.evaluation import Rollout, evaluate
from gym_extensions.baselines.training.jobs import Settings, TrainingJob
from gym_extensions.baselines.training.policies import require_agreement
from gym_extensions.baselines.training.progress import traces_folder
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, evaluation_seed
from gym_extensions.catalog.task import Task
from gym_extensions.envs import make_vec
from gym_extensions.envs.fingerprint import fingerprint_of
from gym_extensions.rollouts.auditing.digests import trace_digest
from gym_extensions.rollouts.episodes import Episode
from gym_extensions.rollouts.layout import trace_name
from gym_extensions.rollouts.policies import Policy
from gym_extensions.rollouts.traces import trace_arrays, trace_bytes


class Evaluator:
    """The evaluation environments of every task, created on first use and reused in every stage."""

    def __init__(self, job: TrainingJob, settings: Settings, out: Path) -> None:
        self._job, self._traces = job, traces_folder(out, job.group.name)
        self._task_is_observed = settings.observes.task_in_evaluation
        self._envs: dict[tuple[str, int], VectorEnv] = {}

    def envs(self, task: Task, episodes: int = EVALUATION_EPISODES) -> VectorEnv:
        """One environment of the task per episode."""
        if (task.id, episodes) not in self._envs:
            self._envs[task.id, episodes] = make_vec(task, episodes)
        return self._envs[task.id, episodes]

    def evaluate(self, agent: Agent, stage: int, task: Task, policy: Policy | None) -> list[Episode]:
        """Evaluates the agent on a task, stores the traces, and compares them with the policy."""
        job, rows = self._job, []
        seeds, rollouts = self._rollouts(agent, task, EVALUATION_EPISODES, task.body.segments.steps)
        for episode, (seed, rollout) in enumerate(zip(seeds, rollouts, strict=True)):
            result = (rollout.length, rollout.return_, rollout.terminated, rollout.success)
            digest = ""
            if rollout.trace is not None:
                name = trace_name(job.protocol, job.run, stage, task.name, episode)
                write_bytes(self._traces / name, trace_bytes(rollout.trace))
                digest = trace_digest(trace_arrays(rollout.trace), *result)
            rows.append(
                Episode(job.run, stage, task.id, episode, seed, *result, fingerprint_of(task), digest)
            )
        if policy is not None:
            actions = [rollout.trace.actions[0] for rollout in rollouts if rollout.trace is not None]
            require_agreement(policy, self.envs(task), seeds, actions, job.group.tasks.index(task))
        return rows

    def mean_returns(self, agent: Agent, tasks: Sequence[Task], episodes: int) -> Iterator[float]:
        """The mean return on each task over the first episodes. Nothing is stored."""
        for task in tasks:
            yield fmean(rollout.return_ for rollout in self._rollouts(agent, task, episodes)[1])

    def _rollouts(
        self, agent: Agent, task: Task, episodes: int, segment_steps: int = 0
    ) -> tuple[list[int], list[Rollout]]:
        group = self._job.group
        seeds = [evaluation_seed(group.id, task.id, episode) for episode in range(episodes)]
        label = TaskLabel(task.id, group.task_ids.index(task.id)) if self._task_is_observed else None
        return seeds, evaluate(agent, self.envs(task, episodes), seeds, segment_steps, label)

    def close(self) -> None:
        """Closes every environment."""
        for env in self._envs.values():
            env.close()

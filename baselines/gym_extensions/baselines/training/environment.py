"""The environment of ``learn``, and what is reported and stored while a stage trains.

It clips actions, counts transitions, records the training curve, and gives the agent what it asked to
observe.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from gym_extensions.baselines.agent import Array, Observes, VectorEnv, not_requested
from gym_extensions.baselines.training.events import BatchTrained, Listener, TaskEvaluated
from gym_extensions.baselines.training.jobs import Interim, Stage, TrainingJob, seeded_copy, spawn_seeds
from gym_extensions.catalog.tasks import Task
from gym_extensions.envs.rollout import clip_actions
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.log import CurvePoint, append_curves
from gym_extensions.rollouts.run import Curve, InterimEvaluation

SPACES = ("single_observation_space", "single_action_space", "observation_space", "action_space")
EXCESS = 0.02
"""Fraction of the budget by which an agent's last batch may exceed it."""


@dataclass(frozen=True)
class TrainingContext:
    """What a stage offers to agents that ask for it.

    Args:
        observes: what the agent asked for.
        group_ids: the ids of the group's tasks in training order; the trained tasks if empty.
        stage: the number of the stage, from 1.
    """

    observes: Observes = field(default_factory=Observes)
    group_ids: tuple[str, ...] = ()
    stage: int = 1


class Point(NamedTuple):
    """Mean return of the training episodes of one task that ended since the previous point."""

    task: str
    step: int
    return_: float


@dataclass(frozen=True)
class Batch:
    """Training since the previous report.

    Args:
        step: training steps taken so far.
        points: the new points of the curve.
        mean_return: of the episodes of all tasks that ended; None if none ended.
        steps: training steps since the previous report.
        seconds: since the previous report, without the time that the report took.
    """

    step: int
    points: tuple[Point, ...]
    mean_return: float | None
    steps: int
    seconds: float

    @property
    def speed(self) -> float:
        """Training steps per second."""
        return self.steps / max(self.seconds, 1e-9)


class TrainingEnv(gym.vector.VectorWrapper):
    """A vector environment that records training correctly whatever the agent does with it.

    ``batch_steps`` and ``budget_steps`` can always be read. The attributes that tell the task or the stage
    raise ``BenchError`` unless the agent's ``observes`` has the field that they need. ``unwrapped`` is this
    environment, so that no step is taken past it.

    Args:
        env: environments in autoreset mode NEXT_STEP; environment i runs ``task_ids[i % len(task_ids)]``.
        task_ids: the tasks that are trained.
        steps: the budget: transitions that the agent may take.
        batch_steps: the budget's batch size. It is also the interval between points of the curve.
        seed: of the first reset, the spaces and ``np_random``; seeds that the agent passes are ignored.
        report: called after every batch, within ``step``; the agent has not yet received the observations.
        context: what the agent asked for, and the stage. By default it asked for nothing.
    """

    def __init__(
        self,
        env: VectorEnv,
        task_ids: Sequence[str],
        *,
        steps: int,
        batch_steps: int,
        seed: int,
        report: Callable[[Batch], object] = lambda _: None,
        context: TrainingContext | None = None,
    ) -> None:
        super().__init__(env)
        self.batch_steps, self.budget_steps = batch_steps, steps
        self._trained, self._context = tuple(task_ids), context or TrainingContext()
        self._group_ids = self._context.group_ids or self._trained
        self.taken, self.points = 0, list[Point]()
        self._report = report
        self._seeds = np.random.SeedSequence(seed)
        *space_seeds, generator_seed = spawn_seeds(spawn_seeds(seed, self.num_envs + 1)[-1], len(SPACES) + 1)
        self._generator = np.random.default_rng(generator_seed)
        for name, space_seed in zip(SPACES, space_seeds, strict=True):
            setattr(self, name, seeded_copy(getattr(env, name), space_seed))
        self._resetting = np.ones(self.num_envs, bool)
        self._sums = np.zeros(self.num_envs)
        self._ended: dict[str, list[float]] = {task: [] for task in task_ids}
        self._next_point = batch_steps
        self._reported, self._since = 0, time.perf_counter()

    @property
    def task_ids(self) -> tuple[str, ...]:
        """The ids of the tasks that are trained, in order. Needs ``task_in_training``."""
        self._require("task_in_training", "task_ids")
        return self._trained

    @property
    def env_task_ids(self) -> tuple[str, ...]:
        """The id of each environment's task. Needs ``task_in_training``."""
        self._require("task_in_training", "env_task_ids")
        return tuple(self._trained[i % len(self._trained)] for i in range(self.num_envs))

    @property
    def env_tasks(self) -> NDArray[np.int64]:
        """The index of each environment's task in the training order of its group, (num_envs,).

        Needs ``task_in_training``.
        """
        self._require("task_in_training", "env_tasks")
        return np.array([self._group_ids.index(task) for task in self.env_task_ids], np.int64)

    @property
    def stage(self) -> int:
        """The number of the stage, from 1. Needs ``boundaries``."""
        self._require("boundaries", "stage")
        return self._context.stage

    @property
    def num_tasks(self) -> int:
        """The number of tasks in the group. Needs ``boundaries``."""
        self._require("boundaries", "num_tasks")
        return len(self._group_ids)

    @property
    def unwrapped(self) -> Any:
        """This environment."""
        return self

    @property
    def spec(self) -> Any:  # type: ignore[override]
        """The wrapped environment's, which names the task; None unless ``task_in_training`` is set."""
        return self.env.spec if self._context.observes.task_in_training else None

    @property  # type: ignore[misc]  # Gymnasium's has a setter
    def np_random(self) -> np.random.Generator:
        """A generator that the run's seed determines; the environments have their own."""
        return self._generator

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Same as the wrapped environment's ``call``. ``task`` needs ``task_in_training``."""
        if name == "task":
            self._require("task_in_training", f"call({name!r})")
        environments: Any = self.env  # VectorEnv does not declare call, but its implementations have it
        values: tuple[Any, ...] = environments.call(name, *args, **kwargs)
        return values

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """Same as ``call`` without arguments."""
        return self.call(name)

    def _require(self, field_name: str, name: str) -> None:
        if not getattr(self._context.observes, field_name):
            raise not_requested(f"env.{name}", field_name)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Resets all environments, or those in ``options["reset_mask"]``, with the run's own seeds."""
        mask = None if options is None else options.get("reset_mask")
        selected = np.ones(self.num_envs, bool) if mask is None else np.array(mask, bool)
        self._resetting[selected] = False
        self._sums[selected] = 0.0
        if mask is not None:
            return self.env.reset(options=options)
        new_seed = int(self._seeds.spawn(1)[0].generate_state(1)[0])
        seeds: Any = spawn_seeds(new_seed, self.num_envs)  # VectorEnv does not declare lists of seeds
        return self.env.reset(seed=seeds, options=options)

    def step(self, actions: Array) -> tuple[Any, Array, Array, Array, dict[str, Any]]:
        """Steps all environments with clipped actions.

        Raises:
            BenchError: the agent exceeded its budget, or the actions have the wrong shape.
        """
        applied = clip_actions(actions, self.env, "env.step() in learn()")
        observations, rewards, terminated, truncated, infos = self.env.step(applied)
        is_transition = ~self._resetting
        self.taken += int(is_transition.sum())
        self._sums += np.where(is_transition, rewards, 0.0)
        self._resetting = (terminated | truncated) & is_transition
        for i in map(int, np.flatnonzero(self._resetting)):
            self._ended[self._trained[i % len(self._trained)]].append(float(self._sums[i]))
            self._sums[i] = 0.0
        if self.taken >= self._next_point:
            self._next_point += self.batch_steps * (1 + (self.taken - self._next_point) // self.batch_steps)
            self.flush()
        if self.taken > self.budget_steps * (1 + EXCESS):
            raise BenchError(
                "budget-exceeded",
                f"The agent took {self.taken} training steps; its budget is {self.budget_steps}.",
                where="learn()",
                hint=f"Stop after the number of steps passed to learn(); {EXCESS:.0%} more are allowed.",
            )
        return observations, rewards, terminated, truncated, infos

    def flush(self) -> None:
        """Adds a point for every task with newly ended episodes, and reports the new steps."""
        if self.taken == self._reported:
            return
        returns = [each for ended in self._ended.values() for each in ended]
        points = tuple(
            Point(task, self.taken, float(np.mean(ended))) for task, ended in self._ended.items() if ended
        )
        for ended in self._ended.values():
            ended.clear()
        self.points += points
        mean_return = float(np.mean(returns)) if returns else None
        seconds = time.perf_counter() - self._since
        batch = Batch(self.taken, points, mean_return, self.taken - self._reported, seconds)
        self._reported = self.taken
        self._report(batch)
        self._since = time.perf_counter()


class StageMonitor:
    """Receives the batches of one stage.

    Args:
        job: the job.
        stage: its stage.
        job_step: training steps of the stages before.
        curve: the file to which the points of the curve are appended.
        listen: receives the events.
        interim: when to evaluate during training; None evaluates at the end of the stage only.
        evaluate: the mean return of each of several tasks, over a number of episodes per task.
    """

    def __init__(
        self,
        job: TrainingJob,
        stage: Stage,
        job_step: int,
        *,
        curve: Path,
        listen: Listener,
        interim: Interim | None,
        evaluate: Callable[[Sequence[Task], int], Iterable[float]],
    ) -> None:
        self._job, self._stage, self._job_step, self._curve = job, stage, job_step, curve
        self._listen, self._interim, self._evaluate = listen, interim, evaluate
        self._next = interim.every if interim else stage.steps
        number, episodes = stage.number, interim.episodes if interim else 0
        self._curves = {
            task.id: Curve(stage=number, task=task.id, steps=[], returns=[]) for task in stage.trained
        }
        self._evaluations = {
            task.id: InterimEvaluation(stage=number, task=task.id, episodes=episodes, steps=[], returns=[])
            for task in stage.evaluated
        }

    @property
    def curves(self) -> list[Curve]:
        """The training curves that have points, in training order."""
        return [curve for curve in self._curves.values() if curve.steps]

    @property
    def evaluations(self) -> list[InterimEvaluation]:
        """The evaluations during training, in training order of the tasks."""
        return [each for each in self._evaluations.values() if each.steps]

    def __call__(self, batch: Batch) -> None:
        """Appends the points to the curves, sends the events and evaluates if it is time to."""
        job, stage = self._job, self._stage
        for point in batch.points:
            self._curves[point.task].steps.append(point.step)
            self._curves[point.task].returns.append(point.return_)
        append_curves(self._curve, [CurvePoint(job.protocol, job.run, *point) for point in batch.points])
        where = (job.title, stage.number, batch.step, self._job_step + batch.step)
        self._listen(BatchTrained(*where, batch.mean_return, batch.speed, batch.seconds))
        if self._interim is not None and self._next <= batch.step < stage.steps:
            self._next = self._interim.every * (1 + batch.step // self._interim.every)
            start = time.perf_counter()
            mean_returns = self._evaluate(stage.evaluated, self._interim.episodes)
            for task, mean_return in zip(stage.evaluated, mean_returns, strict=True):
                self._evaluations[task.id].steps.append(batch.step)
                self._evaluations[task.id].returns.append(mean_return)
                seconds, start = time.perf_counter() - start, time.perf_counter()
                result = (task.id, self._interim.episodes, mean_return, seconds)
                self._listen(TaskEvaluated(*where, *result, in_training=True))

"""The environment of ``learn``: clips actions, counts steps, records returns, shows what was asked for."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from gym_extensions.baselines.agent import EXCESS, NEEDS, Array, VectorEnv, not_requested
from gym_extensions.baselines.generators import seeded_copy, spawn_seeds
from gym_extensions.envs import rollout, vector_env
from gym_extensions.errors import BenchError
from gym_extensions.submissions.manifest import Observes

SPACES = ("single_observation_space", "single_action_space", "observation_space", "action_space")
SILENCE = 10.0
"""Seconds without a report after which a slow agent shows how far it is."""
NOTHING = Observes()
Value = TypeVar("Value")


@dataclass(frozen=True)
class Report:
    """Training since the previous report."""

    step: int  # training steps so far
    steps: int  # training steps since the previous report
    seconds: float  # without the time that reports took
    returns: Mapping[str, float]  # mean return of the episodes that ended, by task
    mean_return: float | None  # of the episodes of all tasks; None if none ended


class TrainingEnv(gym.vector.VectorWrapper):
    """A vector environment that records training correctly whatever the agent does with it.

    ``batch_steps`` and ``budget_steps`` can always be read. The attributes that tell the task or the stage
    raise ``BenchError`` unless the agent's ``observes`` has the field that they need. ``unwrapped`` is this
    environment, so that no step is taken past it.

    Args:
        env: environments in any autoreset mode; environment i runs ``task_ids[i % len(task_ids)]``.
        task_ids: the tasks that are trained.
        steps: the budget: transitions that the agent may take.
        batch_steps: the budget's batch size. It is also the interval between reports.
        seed: of the resets, the spaces and ``np_random``; seeds that the agent passes are ignored.
        report: called after every batch, within ``step``; the agent has not yet received the observations.
        tick: called after ``SILENCE`` seconds without a report, with the steps so far and those per second.
        observes: what the agent asked for.
        group_ids: the ids of the group's tasks in training order; the trained tasks if empty.
        stage: the number of the stage, from 1.
    """

    def __init__(
        self,
        env: VectorEnv,
        task_ids: Sequence[str],
        *,
        steps: int,
        batch_steps: int,
        seed: int,
        report: Callable[[Report], object] = lambda _: None,
        tick: Callable[[int, float], object] = lambda *_: None,
        observes: Observes = NOTHING,
        group_ids: Sequence[str] = (),
        stage: int = 1,
    ) -> None:
        super().__init__(env)
        self.batch_steps, self.budget_steps, self.taken = batch_steps, steps, 0
        self._trained, self._group_ids = tuple(task_ids), tuple(group_ids or task_ids)
        self._report, self._tick, self._observes, self._stage = report, tick, observes, stage
        self._seeds = np.random.SeedSequence(seed)
        *space_seeds, generator_seed = spawn_seeds(spawn_seeds(seed, self.num_envs + 1)[-1], len(SPACES) + 1)
        self._generator = np.random.default_rng(generator_seed)
        for name, space_seed in zip(SPACES, space_seeds, strict=True):
            setattr(self, name, seeded_copy(getattr(env, name), space_seed))
        self.autoreset_mode = AutoresetMode(env.metadata.get("autoreset_mode", AutoresetMode.NEXT_STEP))
        self._resetting = np.ones(self.num_envs, bool)  # whose next step is no transition
        self._sums = np.zeros(self.num_envs)
        self._ended: dict[str, list[float]] = {task: [] for task in task_ids}
        self._next_report, self._reported, self._since = batch_steps, 0, time.perf_counter()
        self._shown = self._since

    @property
    def task_ids(self) -> tuple[str, ...]:
        """The ids of the tasks that are trained, in order. Needs ``task_in_training``."""
        return self._requested("task_ids", self._trained)

    @property
    def env_task_ids(self) -> tuple[str, ...]:
        """The id of each environment's task. Needs ``task_in_training``."""
        ids = tuple(self._trained[i % len(self._trained)] for i in range(self.num_envs))
        return self._requested("env_task_ids", ids)

    @property
    def env_tasks(self) -> NDArray[np.int64]:
        """The index of each environment's task in the training order of its group, (num_envs,).

        Needs ``task_in_training``.
        """
        self._requested("env_tasks", None)
        return np.array([self._group_ids.index(task) for task in self.env_task_ids], np.int64)

    @property
    def stage(self) -> int:
        """The number of the stage, from 1. Needs ``boundaries``."""
        return self._requested("stage", self._stage)

    @property
    def num_tasks(self) -> int:
        """The number of tasks in the group. Needs ``boundaries``."""
        return self._requested("num_tasks", len(self._group_ids))

    def _requested(self, name: str, value: Value) -> Value:
        if not getattr(self._observes, NEEDS[name]):
            raise not_requested(f"env.{name}", NEEDS[name])
        return value

    @property
    def unwrapped(self) -> Any:
        return self

    @property
    def spec(self) -> Any:  # type: ignore[override]
        """The wrapped environment's, which names the task; None unless ``task_in_training`` is set."""
        return self.env.spec if self._observes.task_in_training else None

    @property  # type: ignore[misc]  # Gymnasium's has a setter
    def np_random(self) -> np.random.Generator:
        """A generator that the run's seed determines; the environments have their own."""
        return self._generator

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Same as the wrapped environment's ``call``. ``task`` needs ``task_in_training``."""
        if name == "task" and not self._observes.task_in_training:
            raise not_requested("env.call('task')", "task_in_training")
        environments: Any = self.env  # VectorEnv does not declare call, but its implementations have it
        return environments.call(name, *args, **kwargs)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        return self.call(name)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Resets all environments, or those in ``options["reset_mask"]``, with the run's own seeds."""
        selected = vector_env.reset_mask(options, self.num_envs)
        self._resetting[selected] = False
        self._sums[selected] = 0.0
        if options and options.get("reset_mask") is not None:
            return self.env.reset(options=options)
        new_seed = int(self._seeds.spawn(1)[0].generate_state(1)[0])
        seeds: Any = spawn_seeds(new_seed, self.num_envs)  # VectorEnv does not declare lists of seeds
        return self.env.reset(seed=seeds, options=options)

    def step(self, actions: Array) -> tuple[Any, Array, Array, Array, dict[str, Any]]:
        """Steps all environments with clipped actions.

        Raises ``BenchError`` if the agent exceeded its budget, or the actions have the wrong shape.
        """
        applied = rollout.clip_actions(actions, self.env, "env.step() in learn()")
        observations, rewards, terminated, truncated, infos = self.env.step(applied)
        is_transition = ~self._resetting
        self.taken += int(is_transition.sum())
        self._sums += np.where(is_transition, rewards, 0.0)
        ended = (terminated | truncated) & is_transition
        self._resetting = ended & (self.autoreset_mode is AutoresetMode.NEXT_STEP)
        for i in map(int, np.flatnonzero(ended)):
            self._ended[self._trained[i % len(self._trained)]].append(float(self._sums[i]))
            self._sums[i] = 0.0
        if self.taken >= self._next_report:
            missed = (self.taken - self._next_report) // self.batch_steps
            self._next_report += self.batch_steps * (1 + missed)
            self.flush()
        elif (now := time.perf_counter()) > self._shown + SILENCE:
            self._shown = now
            self._tick(self.taken, (self.taken - self._reported) / (now - self._since))
        if self.taken > self.budget_steps * (1 + EXCESS):
            message = f"The agent took {self.taken} training steps; its budget is {self.budget_steps}."
            hint = f"Stop after the number of steps passed to learn(); {EXCESS:.0%} more are allowed."
            hint += f" A step of all {self.num_envs} environments counts {self.num_envs}."
            raise BenchError("budget-exceeded", message, f"learn(), {self.place}", hint)
        return observations, rewards, terminated, truncated, infos

    @property
    def place(self) -> str:
        """The stage and the steps so far, for errors."""
        return f"stage {self._stage}, after {self.taken:,} of {self.budget_steps:,} steps"

    def flush(self) -> None:
        """Reports the steps since the last report, if there are any."""
        if self.taken == self._reported:
            return
        steps, seconds = self.taken - self._reported, time.perf_counter() - self._since
        everything = [each for ended in self._ended.values() for each in ended]
        returns = {task: float(np.mean(ended)) for task, ended in self._ended.items() if ended}
        for ended in self._ended.values():
            ended.clear()
        self._reported = self.taken
        mean_return = float(np.mean(everything)) if everything else None
        self._report(Report(self.taken, steps, seconds, returns, mean_return))
        self._since = self._shown = time.perf_counter()

"""The training environment: clips actions, counts transitions and records the training curve."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gym_extensions.baselines.agent import Array, VectorEnv
from gym_extensions.baselines.training.actions import clip_actions
from gym_extensions.baselines.training.context_env import ContextEnv, TrainingContext
from gym_extensions.errors import BenchError

EXCESS = 0.02
"""Fraction of the budget by which an agent's last batch may exceed it."""


@dataclass(frozen=True)
class Point:
    """Mean return of the training episodes of one task that ended since the previous point."""

    task: str
    step: int
    return_: float


class Recorder(ContextEnv):
    """A vector environment that records training correctly whatever the agent does with it.

    Args:
        env: environments in autoreset mode NEXT_STEP; environment i runs ``task_ids[i % len(task_ids)]``.
        task_ids: the tasks that are trained.
        steps: the budget: transitions that the agent may take.
        batch_steps: the budget's batch size. It is also the interval between points of the curve.
        seed: of the first reset; seeds that the agent passes are ignored.
        report: called with the number of transitions after every batch.
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
        report: Callable[[int], object] = lambda _: None,
        context: TrainingContext | None = None,
    ) -> None:
        context = context or TrainingContext()
        super().__init__(env, task_ids, budget_steps=steps, batch_steps=batch_steps, context=context)
        self.taken, self.points = 0, list[Point]()
        self._budget, self._report = steps, report
        self._seeds = np.random.SeedSequence(seed)
        self._resetting = np.ones(self.num_envs, bool)
        self._sums = np.zeros(self.num_envs)
        self._ended: dict[str, list[float]] = {task: [] for task in task_ids}
        self._next_point = batch_steps

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
        return self.env.reset(seed=new_seed, options=options)

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
        if self.taken > self._budget * (1 + EXCESS):
            raise BenchError(
                "budget-exceeded",
                f"The agent took {self.taken} training steps; its budget is {self._budget}.",
                where="learn()",
                hint=f"Stop after the number of steps passed to learn(); {EXCESS:.0%} more are allowed.",
            )
        return observations, rewards, terminated, truncated, infos

    def flush(self) -> None:
        """Adds a point for every task with newly ended episodes and reports the transitions."""
        for task, returns in self._ended.items():
            if returns:
                self.points.append(Point(task, self.taken, float(np.mean(returns))))
                returns.clear()
        self._report(self.taken)

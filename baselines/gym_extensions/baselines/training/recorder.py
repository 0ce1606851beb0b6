"""The environment that an agent learns in: clips its actions, counts its steps, writes its curve."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np

from gym_extensions.baselines.agent import Array, VectorEnv
from gym_extensions.baselines.training.actions import clipped
from gym_extensions.errors import BenchError

EXCESS = 0.02
"""Part of the budget by which an agent's last batch may exceed it."""


@dataclass(frozen=True)
class Point:
    """Mean return of the training episodes of one task that ended since the point before."""

    task: str
    step: int
    return_: float


class Recorder(gym.vector.VectorWrapper):
    """A vector environment whose log is right whatever the agent does with it.

    Args:
        env: lanes in autoreset mode NEXT_STEP; lane i holds ``task_ids[i mod len(task_ids)]``.
        task_ids: the tasks trained here.
        steps: the budget: transitions that the agent may take.
        batch_steps: the budget's batch; also how often the curve gets a point, where an episode has ended.
        seed: of the first reset; whatever seed the agent passes is ignored.
        report: told the number of transitions after every batch.
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
    ) -> None:
        super().__init__(env)
        self.batch_steps, self.taken, self.points = batch_steps, 0, list[Point]()
        self._tasks, self._budget, self._report = task_ids, steps, report
        self._seeds = np.random.SeedSequence(seed)
        self._between = np.ones(self.num_envs, bool)
        self._sums = np.zeros(self.num_envs)
        self._ended: dict[str, list[float]] = {task: [] for task in task_ids}
        self._next_point = batch_steps

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """First observations; ``options["reset_mask"]`` resets those lanes alone; seeded by the run."""
        mask = None if options is None else options.get("reset_mask")
        which = np.ones(self.num_envs, bool) if mask is None else np.array(mask, bool)
        self._between[which] = False
        self._sums[which] = 0.0
        if mask is not None:
            return self.env.reset(options=options)
        fresh = int(self._seeds.spawn(1)[0].generate_state(1)[0])
        return self.env.reset(seed=fresh, options=options)

    def step(self, actions: Array) -> tuple[Any, Array, Array, Array, dict[str, Any]]:
        """One step of every lane with clipped actions; raises ``BenchError`` above the budget."""
        observations, rewards, ends, cuts, infos = self.env.step(
            clipped(actions, self.env, "env.step() in learn()")
        )
        real = ~self._between
        self.taken += int(real.sum())
        self._sums += np.where(real, rewards, 0.0)
        self._between = (ends | cuts) & real
        for lane in map(int, np.flatnonzero(self._between)):
            self._ended[self._tasks[lane % len(self._tasks)]].append(float(self._sums[lane]))
            self._sums[lane] = 0.0
        if self.taken >= self._next_point:
            self._next_point += self.batch_steps * (1 + (self.taken - self._next_point) // self.batch_steps)
            self.flush()
        if self.taken > self._budget * (1 + EXCESS):
            raise BenchError(
                "budget-exceeded",
                f"The agent took {self.taken} training steps of a budget of {self._budget}.",
                where="learn",
                hint=f"Stop after the steps that learn() is given; at most {EXCESS:.0%} more are allowed.",
            )
        return observations, rewards, ends, cuts, infos

    def flush(self) -> None:
        """Writes a point for every task with episodes ended since its last, and tells the steps taken."""
        for task, returns in self._ended.items():
            if returns:
                self.points.append(Point(task, self.taken, float(np.mean(returns))))
                returns.clear()
        self._report(self.taken)

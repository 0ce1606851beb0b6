"""Episodes that an attacker records with this project's own code, as often as it likes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any

import numpy as np

from gym_extensions.baselines.agent import Array
from gym_extensions.baselines.training.evaluation import Rollout, evaluate
from gym_extensions.catalog.registry import TASKS
from gym_extensions.envs import make_vec
from gym_extensions.rollouts.policies import Policy

from .forger import Forger, Row, cells

Act = Callable[[Array], Array]


class Acts:
    """An agent of a function from observations to actions."""

    def __init__(self, act: Act) -> None:
        self.act = act

    def learn(self, env: Any, steps: int) -> None:
        """Does nothing."""


@cache
def environments(task: str, count: int = 20) -> Any:
    """That many environments of a task, which are reused."""
    return make_vec(TASKS[task], count)


def rollouts(task: str, act: Act, seeds: Sequence[int]) -> list[Rollout]:
    """An episode per seed, with its trace."""
    env = environments(task, len(seeds))
    return evaluate(Acts(act), env, seeds, TASKS[task].body.segments.steps)


def uniform(task: str, rng: np.random.Generator) -> Act:
    """Uniformly random actions."""
    space = environments(task).single_action_space
    return lambda observations: rng.uniform(space.low, space.high, (len(observations), *space.shape))


def with_policy(policy: Policy, rng: np.random.Generator) -> Act:
    """The actions of a policy."""
    return lambda observations: policy.act(observations, rng)


class Replayed:
    """Actions (steps, environments, …) in order, whatever is observed, and random ones after them."""

    def __init__(self, actions: Array, act: Act) -> None:
        self.actions, self._step, self._act = actions, 0, act

    def __call__(self, observations: Array) -> Array:
        """The actions of the next step."""
        self._step += 1
        if self._step <= len(self.actions):
            return np.asarray(self.actions[self._step - 1])
        return self._act(observations)


def seeds_of(cell: Sequence[Row]) -> list[int]:
    """The prescribed seeds of a cell."""
    return [int(row["seed"]) for row in cell]


def best(candidates: Sequence[Sequence[Rollout]]) -> list[Rollout]:
    """The best of several evaluations, episode by episode."""
    return [max(episodes, key=lambda rollout: rollout.return_) for episodes in zip(*candidates, strict=True)]


def searched(task: str, seeds: Sequence[int], rng: np.random.Generator, rounds: int) -> list[Rollout]:
    """Episodes whose actions were searched for each seed: the best so far, changed in its last part."""
    act = uniform(task, rng)
    top = rollouts(task, act, seeds)
    for _ in range(rounds):
        longest = max(rollout.length for rollout in top)
        space = environments(task).single_action_space
        actions = rng.uniform(space.low, space.high, (longest, len(seeds), *space.shape))
        for index, rollout in enumerate(top):
            assert rollout.trace is not None
            first = int(rollout.length * rng.uniform(0.3, 0.9))
            actions[:first, index] = rollout.trace.actions[:first]
        top = best([top, rollouts(task, Replayed(actions, act), seeds)])
    return top


def replace_cells(
    forger: Forger, episodes: Callable[[Sequence[Row]], Sequence[Rollout]], protocol: str = "single"
) -> None:
    """Gives the cells of a log other episodes."""
    rows = forger.rows(protocol)
    for cell in cells(rows):
        for row, rollout in zip(cell, episodes(cell), strict=True):
            forger.put_rollout(row, rollout, protocol)
    forger.write(rows, protocol)


def generator(cell: Sequence[Row]) -> np.random.Generator:
    """A generator that differs from cell to cell."""
    return np.random.default_rng([int(cell[0]["run"]), int(cell[0]["stage"]), len(cell[0]["task"])])


def evaluations(cell: Sequence[Row], count: int) -> Iterator[list[Rollout]]:
    """Several evaluations of the random agent on a cell."""
    act = uniform(cell[0]["task"], generator(cell))
    return (rollouts(cell[0]["task"], act, seeds_of(cell)) for _ in range(count))

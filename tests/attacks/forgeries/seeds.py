"""Makes the attacks of the table of the same name in `families`."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from pathlib import Path
from statistics import fmean

import numpy as np

from gym_extensions.baselines.training.evaluation import Rollout
from gym_extensions.rollouts.policies import Policy

from ..evaluate import (
    best,
    evaluations,
    generator,
    replace_cells,
    rollouts,
    searched,
    seeds_of,
    uniform,
    with_policy,
)
from ..forger import Forger, Row, cells
from ..judge import Make
from ..recorders import RUNS
from ..workshop import Workshop

Episodes = Callable[[Sequence[Row]], Sequence[Rollout]]


def with_episodes(episodes: Episodes, *, policies: bool = True, base: str = "random") -> Make:
    """Gives all cells other episodes, and leaves the policies out if asked to."""

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy(base))
        replace_cells(forger, episodes)
        if not policies:
            shutil.rmtree(forger.folder / forger.group.name / "policies")
        return forger.commit()

    return make


def with_policy_file(episodes: Episodes, policy: Callable[[], Policy]) -> Make:
    """Gives all cells other episodes, and all runs this policy file."""

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy("random"))
        replace_cells(forger, episodes)
        forger.put_policy(policy(), RUNS)
        return forger.commit()

    return make


def best_episodes(count: int) -> Episodes:
    """The best of several evaluations, episode by episode."""
    return lambda cell: best(list(evaluations(cell, count)))


def best_evaluation(cell: Sequence[Row]) -> Sequence[Rollout]:
    """The best of ten evaluations of a cell."""
    return max(list(evaluations(cell, 10)), key=mean)


def mean(episodes: Iterable[Rollout]) -> float:
    return fmean(rollout.return_ for rollout in episodes)


def open_loop(cell: Sequence[Row]) -> Sequence[Rollout]:
    """Actions that were searched for every prescribed seed."""
    return searched_once(cell[0]["task"], int(cell[0]["run"]), tuple(seeds_of(cell)))


@cache
def searched_once(task: str, run: int, seeds: tuple[int, ...]) -> list[Rollout]:
    return searched(task, seeds, np.random.default_rng([run, len(task)]), rounds=5)


def lucky_seeds(cell: Sequence[Row]) -> Sequence[Rollout]:
    """The best 20 episodes of 60 other seeds."""
    task, act = cell[0]["task"], uniform(cell[0]["task"], generator(cell))
    episodes = [rollout for start in (0, 20, 40) for rollout in rollouts(task, act, range(start, start + 20))]
    return sorted(episodes, key=lambda rollout: rollout.return_)[-20:]


def linear(rng: np.random.Generator) -> Policy:
    """A linear policy of random weights for Hopper."""
    return Policy(np.zeros(3), np.ones(3), (rng.normal(0, 0.2, (11, 3)),), (np.zeros(3),), squash="tanh")


def wide() -> Policy:
    """A Gaussian policy that any action agrees with."""
    return Policy(np.zeros(3), np.ones(3), head="gaussian", log_sigma=np.full(3, np.log(10.0)))


def always_forward() -> Policy:
    """A deterministic policy without a network."""
    return Policy(np.zeros(3), np.ones(3))


def best_cell(workshop: Workshop) -> Path:
    """Gives one cell the best of five evaluations."""
    forger = Forger(workshop.copy("random"))
    rows = forger.rows()
    cell = cells(rows)[0]
    for row, rollout in zip(cell, max(evaluations(cell, 5), key=mean), strict=True):
        forger.put_rollout(row, rollout)
    forger.write(rows)
    return forger.commit()


def selected_policies(workshop: Workshop) -> Path:
    """Chooses, for every run and task, the best of ten policies on the prescribed seeds."""
    forger = Forger(workshop.copy("random"))
    rows, folder = forger.rows(), forger.folder / forger.group.name / "policies"
    for cell in cells(rows):
        rng, task = generator(cell), cell[0]["task"]
        policies = [linear(rng) for _ in range(10)]
        results = [rollouts(task, with_policy(policy, rng), seeds_of(cell)) for policy in policies]
        index = max(range(10), key=lambda number: mean(results[number]))
        for row, rollout in zip(cell, results[index], strict=True):
            forger.put_rollout(row, rollout)
        name = next(item.name for item in forger.group.tasks if item.id == task)
        path = folder / f"single-run{cell[0]['run']}-stage1-{name}.npz"
        path.unlink()
        path.write_bytes(policies[index].to_bytes())
    forger.write(rows)
    forger.declare("evaluation", '"deterministic"')
    forger.declare("algorithm", '"random search"')
    return forger.commit()


def real_seeds(workshop: Workshop) -> Path:
    """Logs the best 20 of 60 seeds as what they are."""
    forger = Forger(workshop.copy("random"))
    replace_cells(forger, lucky_seeds)
    forger.change(lambda row: row.update(seed=str(int(row["episode"]) + 40)))
    return forger.commit()

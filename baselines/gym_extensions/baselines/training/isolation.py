"""Evaluates an agent in the middle of its training without an effect on what it learns."""

from __future__ import annotations

import random
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from gym_extensions.baselines.agent import Agent, Resumable
from gym_extensions.catalog.task import Task

MeanReturns = Callable[[Agent, Sequence[Task], int], Iterator[float]]
"""The mean return of an agent on each task, over a number of episodes per task."""


def isolated(
    agent: Agent, create: Callable[[], Agent], path: Path, mean_returns: MeanReturns
) -> Callable[[Sequence[Task], int], Iterator[float]]:
    """The function ``mean_returns`` for this agent, without an effect on its training.

    A copy of the agent acts if the agent can be saved, and global random generators are restored afterwards.
    An agent that cannot be saved acts itself, so that its generator for acting moves on.

    Args:
        agent: the agent.
        create: creates an agent of the same kind.
        path: a file that is written and deleted.
        mean_returns: evaluates an agent.
    """

    def of_agent(tasks: Sequence[Task], episodes: int) -> Iterator[float]:
        with preserved_global_generators():
            yield from mean_returns(copy_of(agent, create, path), tasks, episodes)

    return of_agent


@contextmanager
def preserved_global_generators() -> Iterator[None]:
    """Restores the global random generators of Python, numpy and (if it is loaded) torch."""
    torch = sys.modules.get("torch")
    python_state, numpy_state = random.getstate(), np.random.get_state()  # noqa: NPY002
    torch_state = None if torch is None else torch.get_rng_state()
    try:
        yield
    finally:
        random.setstate(python_state)
        np.random.set_state(numpy_state)  # noqa: NPY002
        if torch is not None:
            torch.set_rng_state(torch_state)


def copy_of(agent: Agent, create: Callable[[], Agent], path: Path) -> Agent:
    """A copy of an agent that can be saved: a new agent that loads what it saves. Others are returned as is.

    Args:
        agent: the agent.
        create: creates an agent of the same kind.
        path: a file that is written and deleted.
    """
    if not isinstance(agent, Resumable):
        return agent
    copy = create()
    if not isinstance(copy, Resumable):
        return agent
    try:
        agent.save(path)
        copy.load(path)
    finally:
        path.unlink(missing_ok=True)
    return copy

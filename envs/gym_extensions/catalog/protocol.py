"""The evaluation protocol: stages, evaluation episodes and their prescribed seeds."""

from __future__ import annotations

import hashlib

from gym_extensions.catalog.groups import TaskGroup

PROTOCOLS = ("sequential", "single", "joint")
EVALUATION_EPISODES = 20
FIRST_REFERENCE_RUN = 1000
"""Training seeds from here on are for reference runs alone; a submission may not use them."""
FULL_ENTRY_RUNS = 5
CURVE_POINTS = 10
"""Fewest points of a training curve from which an area under it is computed."""


def evaluation_seed(group_id: str, task_id: str, episode: int) -> int:
    """The prescribed reset seed of an evaluation episode, in [0, 2³¹).

    The first four bytes, little-endian, top bit cleared, of sha256 over ``<group id>/<task id>/<episode>``:
    the same in every stage and run, so that columns are compared on the same starts and nobody chooses them.
    """
    digest = hashlib.sha256(f"{group_id}/{task_id}/{episode}".encode()).digest()
    return int.from_bytes(digest[:4], "little") & 0x7FFF_FFFF


def stages(protocol: str, count: int) -> tuple[int, ...]:
    """The stages that a log of that protocol holds, in a group of that many tasks."""
    return tuple(range(count + 1)) if protocol == "sequential" else (1,)


def per_run(protocol: str, group: TaskGroup) -> int:
    """Rows of one run in a complete log."""
    return len(stages(protocol, len(group.tasks))) * len(group.tasks) * EVALUATION_EPISODES

"""The evaluation protocol prescribes stages, evaluation episodes and their seeds."""

from __future__ import annotations

import hashlib

from gym_extensions.catalog.groups import TaskGroup

PROTOCOLS = ("sequential", "single", "joint")
EVALUATION_EPISODES = 20
FIRST_REFERENCE_RUN = 1000
"""First training seed of reference runs. A submission may not use this seed or a larger one."""
FULL_ENTRY_RUNS = 5
CURVE_POINTS = 10
"""Minimum number of points of a training curve for an area under the curve."""


def evaluation_seed(group_id: str, task_id: str, episode: int) -> int:
    """Returns the prescribed reset seed of an evaluation episode, in [0, 2³¹).

    The seed is the first four bytes, little-endian with the top bit cleared, of the sha256 digest of
    ``<group id>/<task id>/<episode>``. It is the same in every stage and run, so results are compared on the
    same starts, and nobody can choose them.
    """
    digest = hashlib.sha256(f"{group_id}/{task_id}/{episode}".encode()).digest()
    return int.from_bytes(digest[:4], "little") & 0x7FFF_FFFF


def stages(protocol: str, count: int) -> tuple[int, ...]:
    """The stages in a log of the protocol, for a group of ``count`` tasks."""
    return tuple(range(count + 1)) if protocol == "sequential" else (1,)


def per_run(protocol: str, group: TaskGroup) -> int:
    """Number of rows per run in a complete log."""
    return len(stages(protocol, len(group.tasks))) * len(group.tasks) * EVALUATION_EPISODES

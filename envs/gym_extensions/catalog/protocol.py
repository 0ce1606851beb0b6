"""The protocol: stages, evaluation episodes and their seeds, and training budgets."""

import hashlib
from dataclasses import dataclass

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.errors import require_known

PROTOCOLS = ("sequential", "single", "joint", "cumulative", "descending", "balanced")
"""``sequential``: one policy learns the tasks in order. ``single``: one policy per task. ``joint``: one
policy learns all tasks together. ``cumulative``: one policy learns the last task alone, for the steps of the
whole sequence, which tells practice from transfer. ``descending``: as sequential, from the last task to the
first. ``balanced``: as sequential, run r in the order of row r of a balanced square, which tells the task
from its position."""
IN_ORDER = ("sequential", "descending", "balanced")
"""The protocols in which one policy learns the tasks one after another."""
EVALUATION_EPISODES = 20
FIRST_REFERENCE_RUN = 1000
"""First training seed of reference runs. A submission may not use this seed or a larger one."""
FULL_SUBMISSION_RUNS = 5
CURVE_POINTS = 10
"""Minimum number of points of a training curve for an area under the curve."""


def seed_from(*names: object) -> int:
    """Returns a seed in [0, 2³¹), the first four bytes, little-endian with the top bit cleared, of the sha256
    digest of the names with ``/`` between them."""
    digest = hashlib.sha256("/".join(map(str, names)).encode()).digest()
    return int.from_bytes(digest[:4], "little") & 0x7FFF_FFFF


def evaluation_seed(group_id: str, task_id: str, episode: int) -> int:
    """Returns the prescribed reset seed of an evaluation episode: ``seed_from`` its arguments.

    It is the same in every stage and run, so results are compared on the same starts, and nobody can choose
    them.
    """
    return seed_from(group_id, task_id, episode)


def stages(protocol: str, count: int) -> tuple[int, ...]:
    """The stages in a log of the protocol, for a group of ``count`` tasks."""
    return tuple(range(count + 1)) if protocol in IN_ORDER else (1,)


def balanced_square(count: int) -> tuple[tuple[int, ...], ...]:
    """Orders of ``count`` tasks, given as indices: every task is equally often in every position, and equally
    often right after every other task.

    There are ``count`` rows, for an odd number also their reverses. Source: E. J. Williams, Experimental
    designs balanced for the estimation of residual effects of treatments, Australian Journal of Scientific
    Research A 2, 1949.

    >>> balanced_square(4)
    ((0, 1, 3, 2), (1, 2, 0, 3), (2, 3, 1, 0), (3, 0, 2, 1))
    """
    first = [(place + 1) // 2 if place % 2 else -(place // 2) for place in range(count)]
    rows = tuple(tuple((task + row) % count for task in first) for row in range(count))
    return rows + tuple(row[::-1] for row in rows) if count % 2 and count > 1 else rows


def task_order(protocol: str, run: int, count: int) -> tuple[int, ...]:
    """The indices of a group's ``count`` tasks in the order in which a run learns them.

    A balanced run takes the row of its number, and after the last row the first one again.
    """
    if protocol == "balanced":
        rows = balanced_square(count)
        return rows[run % len(rows)]
    return tuple(range(count))[:: -1 if protocol == "descending" else 1]


@dataclass(frozen=True)
class Budget:
    """Number of training steps per task, ``batches × batch_steps``."""

    name: str
    batches: int  # per task
    batch_steps: int  # environment steps per batch, summed over the environments
    num_envs: int  # environments that are stepped in parallel
    body_batches: int | None = None  # of the paper's body groups, which it trained half as long
    on_boards: bool = True  # whether submissions with this budget appear on the boards

    def steps_for(self, group_name: str) -> int:
        """Training steps per task of the named group."""
        batches = self.batches
        if self.body_batches is not None and group_name.endswith("-body") and group_name in GROUPS:
            batches = self.body_batches
        return batches * self.batch_steps


BUDGETS = {
    budget.name: budget
    for budget in (
        Budget("paper", batches=1000, batch_steps=50_000, num_envs=50, body_batches=500),
        Budget("1M", batches=200, batch_steps=5_000, num_envs=20),
        Budget("300k", batches=150, batch_steps=2_000, num_envs=25),
        Budget("100k", batches=50, batch_steps=2_000, num_envs=8),
        Budget("smoke", batches=4, batch_steps=250, num_envs=1, on_boards=False),
    )
}
STANDARD_BUDGET = "300k"
"""The budget of the standard boards and of the reference agents."""


def budget(name: str) -> Budget:
    """Returns the budget of that name. Raises ``BenchError`` if it does not exist."""
    require_known("budget", name, BUDGETS)
    return BUDGETS[name]


@dataclass(frozen=True)
class Report:
    """The fixed facts of the submission that shows a published table."""

    submission: str
    budget: str
    algorithm: str


REPORTS = {"henderson2017": Report("henderson2017-trpo", "paper", "trpo")}
"""By the name of the table in submission.toml and of its file in ``scoring/published_data/``."""

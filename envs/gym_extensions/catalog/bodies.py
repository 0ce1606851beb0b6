"""How an episode is cut so that it replays on another machine: segment length and tolerance by family.

K is chosen by measurement: across two maths libraries, whole HalfCheetah episodes drift apart, segments of
K = 25 miss 1e-6 once in 936, at K = 10 the worst is 2e-9; the contacts of Pusher and Striker need K ≤ 5.
"""

from __future__ import annotations

from dataclasses import dataclass

from gym_extensions.catalog.task import Task


@dataclass(frozen=True)
class Segments:
    """``steps`` environment steps a segment; replay may differ by ``tolerance`` (absolute, and relative)."""

    steps: int
    tolerance: float


SEGMENTS = {
    "Hopper": Segments(10, 1e-6),
    "Walker2d": Segments(10, 1e-6),
    "HalfCheetah": Segments(10, 1e-6),
    "Humanoid": Segments(10, 1e-6),
    "Pusher": Segments(5, 1e-6),
    "Striker": Segments(5, 1e-6),
    "Navigation": Segments(10, 1e-6),
}
"""One row a family; a base body belongs to the family whose name it begins with."""


def segments(task: Task) -> Segments:
    """The row of the task's family; raises ``ValueError`` for a base body of no family."""
    for family, row in SEGMENTS.items():
        if task.base.startswith(family):
            return row
    raise ValueError(f"no segment length for base {task.base!r}")


@dataclass(frozen=True)
class Bound:
    """Lowest and highest reward of one step; ``end`` is paid once, when the task ends the episode."""

    low: float
    high: float
    terminates: bool = True
    end: float = 0.0


BOUNDS = {
    "Hopper": Bound(-20.0, 20.0),  # 1 for health, and metres a second forward
    "Walker2d": Bound(-25.0, 25.0),  # as Hopper
    "HalfCheetah": Bound(-50.0, 50.0, terminates=False),  # metres a second forward
    "Humanoid": Bound(-50.0, 50.0),  # 5 for health, 1.25 × metres a second, contact cost at most 10
    "HumanoidStandup": Bound(-100.0, 1500.0, terminates=False),  # height over .003 s; 1 m gives 333
    "HumanoidStandupAndRun": Bound(-200.0, 1600.0, terminates=False),  # the two above
    "Pusher": Bound(-30.0, 0.0, terminates=False),  # minus distances in metres, minus squared actions
    "Striker": Bound(-200.0, 0.0, terminates=False),  # as Pusher; the ball may fly off
    "Navigation": Bound(-6.0, -1.0, end=10.0),  # -1 a step, -5 a collision, +10 at the goal
}
"""A row a family of tasks, by the name of the base body."""


WIDEST = Bound(-1e6, 1e6)


def bound(task: Task) -> Bound:
    """The bound of a task: its base's row, or navigation's."""
    return BOUNDS.get(task.base) or (BOUNDS["Navigation"] if "Navigation" in task.name else WIDEST)


def span(task: Task) -> tuple[float, float]:
    """The lowest and the highest return of a whole episode of a task, of whatever length."""
    row = bound(task)
    lengths = (1, task.max_steps)
    return min(row.low * steps for steps in lengths), max(row.high * steps for steps in lengths) + row.end

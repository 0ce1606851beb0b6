"""What a task can give in a step, as data: a return beyond it was not measured in our environments.

The bounds are wide on purpose (several times what the best known policies reach): they catch a wrong column,
a wrong task or an invented number, never an honest log. Rewards: Gymnasium 1.4's v5 classes.
"""

from __future__ import annotations

from dataclasses import dataclass

from gym_extensions.catalog.tasks import Task


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

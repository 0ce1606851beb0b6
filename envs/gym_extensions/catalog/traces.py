"""How an episode is cut so that it replays on another machine: segment length and tolerance by family.

K is chosen by measurement: across two maths libraries, whole HalfCheetah episodes drift apart, segments of
K = 25 miss 1e-6 once in 936, at K = 10 the worst is 2e-9; the contacts of Pusher and Striker need K ≤ 5.
"""

from __future__ import annotations

from dataclasses import dataclass

from gym_extensions.catalog.tasks import Task


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

"""The page Metrics: the definition of every number, with a worked example of one run of three tasks."""

from __future__ import annotations

from collections.abc import Iterator

from gym_extensions import metrics
from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from gym_extensions.site.board_views import Leaderboard
from gym_extensions.site.pages.page import File, Render


def publish(site: Leaderboard, render: Render) -> Iterator[File]:
    """The definition of every number, with an anchor per metric."""
    used = {board.budget for board in site.boards}
    yield "metrics.html", render("metrics.html", "metrics.html", used_budgets=used, example=example())


MATRIX = ((0.0, 0.1, 0.0), (0.8, 0.2, 0.1), (0.5, 0.9, 0.3), (0.4, 0.7, 1.0))
"""p[s][j]: a row per stage from 0, a column per task."""
SINGLE, JOINT, CUMULATIVE = (0.8, 0.8, 0.9), 0.9, 0.95
"""p_single[j], the performance of joint training on every task, and p_cumulative[T]."""
AREAS, SINGLE_AREAS = (0.5, 0.6, 0.7), (0.5, 0.4, 0.5)
"""Areas under the training curves, in sequence and alone."""
SPREAD = 0.02
"""Distance of neighbouring episodes of a cell, which lie evenly around its mean."""


def example() -> dict[str, object]:
    """The numbers of the example, and ``results``: every metric of it by name."""
    offsets = [SPREAD * (at - (EVALUATION_EPISODES - 1) / 2) for at in range(EVALUATION_EPISODES)]
    found = metrics.compute(
        MATRIX,
        SINGLE,
        joint=[JOINT] * len(SINGLE),
        cumulative=CUMULATIVE,
        episodes=[[cell + offset for offset in offsets] for cell in MATRIX[-1]],
        auc=AREAS,
        single_auc=SINGLE_AREAS,
    )
    return {
        "matrix": MATRIX,
        "single": SINGLE,
        "joint": JOINT,
        "areas": AREAS,
        "single_areas": SINGLE_AREAS,
        "spread": SPREAD,
        "results": {name: value.mean for name, value in found.items()},
    }

"""A plot of a board. It needs the extra ``plot``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from gym_extensions.catalog.budgets import STANDARD_BUDGET
from gym_extensions.errors import BenchError, did_you_mean
from gym_extensions.results.axes import new_axes
from gym_extensions.results.scores import board
from gym_extensions.results.submissions import Paths

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot_board(
    data: pd.DataFrame | Paths,
    group: str | None = None,
    *,
    metric: str | None = None,
    protocol: str = "sequential",
    budget: str = STANDARD_BUDGET,
    ax: Axes | None = None,
) -> Axes:
    """A board: one row per entry with the mean of a metric and its 95 % interval, in the order of the
    board.

    Args:
        data: a frame of ``board``, or submissions.
        group: of the board; needed with submissions.
        metric: a metric of the board; its first if None.
        protocol: of the board; used with submissions.
        budget: of the board; used with submissions.
        ax: where to draw; a new figure if None.

    Raises:
        BenchError: matplotlib is missing, the board is empty, or a name is unknown.
    """
    if not isinstance(data, pd.DataFrame) and group is None:
        raise BenchError("bad-plot", "A board is of one group.", "group", "Name it: group='hopper-gravity'.")
    frame = data if isinstance(data, pd.DataFrame) else board(str(group), data, protocol, budget)
    metrics = [name.removesuffix("_low") for name in frame.columns if str(name).endswith("_low")]
    if metric is not None and metric not in metrics:
        hint = did_you_mean(metric, metrics)
        raise BenchError("unknown-metric", f"The board has no metric {metric!r}.", "metric", hint)
    if frame.empty or not metrics:
        raise BenchError("bad-plot", "The board has no entry with a metric.", "data", "Use results.board(…).")
    chosen = metric or metrics[0]
    rows = frame[frame[chosen].notna()]
    axes, heights = new_axes(ax), range(len(rows))
    axes.hlines(heights, rows[f"{chosen}_low"], rows[f"{chosen}_high"], color="0.6")
    axes.plot(rows[chosen], heights, "o", color="C0")
    axes.set_yticks(heights, rows["name"])
    axes.invert_yaxis()
    axes.set(xlabel=f"{chosen.replace('_', ' ')} (0 = floor, 1 = reference)", title=group or "")
    return axes

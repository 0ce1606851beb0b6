"""Plots of boards, curves, returns by stage and task, and retention. They need the extra ``plot``."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from gym_extensions.catalog.protocol import STANDARD_BUDGET
from gym_extensions.errors import BenchError, require_known
from gym_extensions.results.frames import curves, evaluations
from gym_extensions.results.scores import board
from gym_extensions.scoring.pipeline import Paths
from gym_extensions.scoring.submission.stages import task_name

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Data = pd.DataFrame | Paths
"""A data frame, or the submissions from which it is read."""


def new_axes(ax: Axes | None) -> Axes:
    """``ax``, or the axes of a new figure if it is None. Raises ``BenchError`` if matplotlib is missing."""
    try:
        from matplotlib import pyplot
    except ModuleNotFoundError as missing:
        hint = "Install it with: pip install 'gym-extensions[plot]'"
        raise BenchError("missing-extra", f"Plots need {missing.name}.", hint=hint) from missing
    return pyplot.subplots(layout="constrained")[1] if ax is None else ax


def task_colors(tasks: Iterable[str]) -> dict[str, str]:
    """A color of matplotlib's cycle for each task, in the order of the tasks."""
    return {task: f"C{index}" for index, task in enumerate(dict.fromkeys(tasks))}


def plot_board(
    data: Data,
    group: str | None = None,
    *,
    metric: str | None = None,
    protocol: str = "sequential",
    budget: str = STANDARD_BUDGET,
    ax: Axes | None = None,
) -> Axes:
    """A board: one row per submission with the mean of a metric and its 95 % interval, in the order of the
    board.

    Args:
        data: a frame of ``board``, or submissions.
        group: the group of the board. Like ``protocol`` and ``budget``, it is used only if ``data`` are
            submissions.
        metric: a metric of the board; its first if None.
        ax: where to draw; a new figure if None.

    Raises:
        BenchError: matplotlib is missing, the board is empty, or a name is unknown.
    """
    if not isinstance(data, pd.DataFrame) and group is None:
        raise BenchError("bad-plot", "A board is of one group.", "group", "Name it: group='hopper-gravity'.")
    frame = data if isinstance(data, pd.DataFrame) else board(str(group), data, protocol, budget)
    metrics = [name.removesuffix("_low") for name in frame.columns if str(name).endswith("_low")]
    if metric is not None:
        require_known("metric", metric, metrics, "metric")
    if frame.empty or not metrics:
        raise BenchError(
            "bad-plot", "The board has no submission with a metric.", "data", "Use results.board(…)."
        )
    chosen = metric or metrics[0]
    rows = frame[frame[chosen].notna()]
    axes, heights = new_axes(ax), range(len(rows))
    ends = rows[[f"{chosen}_low", f"{chosen}_high"]]
    has_interval = ends.notna().all(axis=1).to_numpy()
    axes.hlines(np.arange(len(rows))[has_interval], *ends[has_interval].to_numpy().T, color="0.6")
    axes.plot(rows[chosen], heights, "o", color="C0")
    axes.set_yticks(heights, rows["name"])
    axes.invert_yaxis()
    axes.set(xlabel=f"{chosen.replace('_', ' ')} (0 = floor, 1 = expert)", title=group or "")
    return axes


def plot_curves(
    data: Data, group: str | None = None, *, protocol: str | None = None, ax: Axes | None = None
) -> Axes:
    """Training curves: the return over the training steps, one line per run, one color per task.

    Args:
        data: a frame of ``curves``, or a submission.
        group: group id or name; needed if there are several groups.
        protocol: needed if there are several protocols.
        ax: where to draw; a new figure if None.

    Raises:
        BenchError: matplotlib is missing, or the data are empty, ambiguous or not of this kind.
    """
    frame = _select(data, curves, ("task", "run", "step", "return"), group, protocol)
    axes, colors = new_axes(ax), task_colors(frame["task"])
    seen = set[str]()
    for keys, line in frame.groupby(["submission", "task", "run"], sort=False):
        task = str(keys[1])
        label = None if task in seen else task_name(task)
        axes.plot(line["step"], line["return"], color=colors[task], linewidth=1, label=label)
        seen.add(task)
    axes.set(xlabel="training steps", ylabel="training return", title=_title(frame))
    axes.legend(fontsize="small")
    return axes


def plot_matrix(data: Data, group: str | None = None, *, ax: Axes | None = None) -> Axes:
    """The matrix of returns: one row per stage of sequential training, one column per task, mean over runs.

    The data are a frame of ``episodes`` or ``evaluations``, or a submission. The other arguments and the
    errors are those of :func:`plot_curves`.
    """
    frame = _select(data, evaluations, ("run", "stage", "task", "return"), group, "sequential")
    if "trained" in frame:
        frame = frame[frame["trained"] == frame["stage"]]
    axes, tasks = new_axes(ax), frame["task"].unique()
    matrix = frame.pivot_table(index="stage", columns="task", values="return", aggfunc="mean")[tasks]
    image = axes.imshow(matrix.to_numpy(), aspect="auto", origin="upper", cmap="viridis")
    for row, values in enumerate(matrix.to_numpy()):
        for column, value in enumerate(values):
            box = {"boxstyle": "round", "facecolor": "white", "edgecolor": "none", "alpha": 0.7}
            axes.text(column, row, f"{value:.0f}", ha="center", va="center", fontsize="small", bbox=box)
    axes.set_xticks(range(len(tasks)), [task_name(task) for task in tasks], rotation=30, ha="right")
    axes.set_yticks(range(len(matrix)), [str(stage) for stage in matrix.index])
    axes.set(ylabel="tasks trained", title=_title(frame))
    axes.figure.colorbar(image, ax=axes, label="mean return")
    return axes


def plot_retention(data: Data, group: str | None = None, *, ax: Axes | None = None) -> Axes:
    """Retention in sequential training: the return on every task while the tasks are trained in order.

    One line per task, the mean over runs, over the number of tasks trained so far. Runs of one submission
    are expected to be evaluated at the same steps. A vertical line marks the
    end of a stage. With evaluations during training the lines have points within the stages.

    The data are a frame of ``evaluations``, or a submission. The other arguments and the errors are those of
    :func:`plot_curves`.
    """
    columns = ("run", "stage", "task", "step", "trained", "return")
    frame = _select(data, evaluations, columns, group, "sequential")
    axes, colors = new_axes(ax), task_colors(frame["task"])
    # Runs have their points at nearly the same steps: the k-th points within a stage belong together.
    is_end = (frame["trained"] == frame["stage"]).rename("is_end")
    point = frame.groupby([frame["run"], frame["stage"], frame["task"], is_end]).cumcount()
    keys = [frame["task"], frame["stage"], is_end, point.rename("point")]
    means = frame.groupby(keys, sort=False)[["trained", "return"]].mean()
    for task, line in means.groupby("task", sort=False):
        ordered = line.sort_values("trained")
        label, color = task_name(str(task)), colors[str(task)]
        axes.plot(ordered["trained"], ordered["return"], color=color, marker=".", label=label)
    for stage in sorted(frame["stage"].unique()):
        axes.axvline(stage, color="0.85", linewidth=0.8, zorder=0)
    axes.locator_params(axis="x", integer=True)
    axes.set(xlabel="tasks trained", ylabel="mean return", title=_title(frame))
    axes.legend(fontsize="small")
    return axes


def _select(
    data: Data,
    read: Callable[[Paths], pd.DataFrame],
    columns: tuple[str, ...],
    group: str | None,
    protocol: str | None,
) -> pd.DataFrame:
    frame = data if isinstance(data, pd.DataFrame) else read(data)
    missing = [name for name in ("submission", "group", "protocol", *columns) if name not in frame]
    if missing:
        message = f"The frame has no column {missing[0]!r}."
        raise BenchError("bad-plot", message, "data", "Pass the frame that the docstring names.")
    if group is not None:
        ids = [name for name in frame["group"].unique() if name == group or name.rpartition("-v")[0] == group]
        frame = frame[frame["group"].isin(ids)]
    if protocol is not None:
        frame = frame[frame["protocol"] == protocol]
    if frame.empty:
        selection = ", ".join(name for name in (group, protocol) if name)
        message = f"There are no rows of {selection}." if selection else "There are no rows."
        raise BenchError("bad-plot", message, "data", "Choose another group or protocol.")
    for name in ("submission", "group", "protocol"):
        values = [str(value) for value in frame[name].unique()]
        if len(values) > 1:
            message = f"The data have several values of {name!r}: {', '.join(values)}."
            raise BenchError("bad-plot", message, "data", "Choose one of them.")
    return frame


def _title(frame: pd.DataFrame) -> str:
    return " · ".join(str(frame[name].iloc[0]) for name in ("submission", "group", "protocol"))

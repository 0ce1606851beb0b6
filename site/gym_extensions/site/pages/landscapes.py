"""Landscapes on the pages: maps and numbers of a submission, and the submissions of a group side by side."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from markupsafe import Markup

from gym_extensions.catalog import groups, worlds
from gym_extensions.errors import BenchError
from gym_extensions.metrics.values import MetricValue
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site.board_views import BoardView, Row
from gym_extensions.site.charts import landscapes as charts, svg
from gym_extensions.submissions import landscapes as model, review
from gym_extensions.submissions.landscapes import PROTOCOL, Landscape

Summary = Mapping[str, MetricValue]
"""Interpolation and extrapolation, without one of which a group has no worlds."""
TITLES = {model.INTERPOLATION: "between trained values", model.EXTRAPOLATION: "beyond trained values"}


@dataclass(frozen=True)
class AxisView:
    """One axis of a landscape: the drawing of the mean, one per run, and the mean returns."""

    axis: worlds.Axis
    stages: tuple[str, ...]
    large: Markup
    runs: tuple[tuple[int, Markup], ...]
    means: tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class View:
    """The landscape of a submission on a group, or why there is none."""

    group: groups.TaskGroup
    landscape: Landscape | None
    best: model.Best
    submissions: int = 0  # that have a landscape of the group
    why: str = ""

    @cached_property
    def summary(self) -> Summary:
        """The shares of the best return."""
        return model.summary(self.landscape, self.group, self.best) if self.landscape else {}

    @property
    def axes(self) -> list[AxisView]:
        """Every axis, drawn."""
        if self.landscape is None:
            return []
        views, tasks = [], range(len(self.group.tasks))
        for axis in worlds.axes(self.group):
            measured, top = self.landscape.axis(axis.name), self.best[self.group.id, axis.name]
            stages = ("untrained", *(_stage(axis, self.group, task) for task in tasks))
            runs = tuple(
                (run, charts.small(axis, _shares(returns, top), f"Run {run}"))
                for run, returns in zip(self.landscape.runs, measured.returns, strict=True)
            )
            final, shares = [run[-1] for run in measured.returns], _shares(measured.means, top)
            large = charts.large(axis, shares, stages, final, measured.means[-1], best=top)
            views.append(AxisView(axis, stages, large, runs, measured.means))
        return views

    @property
    def maps(self) -> dict[str, Markup]:
        """A small map of the mean over runs, by what is varied."""
        found = self.landscape
        means = {axis: found.axis(axis.name).means for axis in worlds.axes(self.group)} if found else {}
        return {
            axis.title: charts.small(axis, _shares(each, self.best[self.group.id, axis.name]), axis.title)
            for axis, each in means.items()
        }


def _shares(returns: tuple[tuple[float, ...], ...], top: tuple[float, ...]) -> list[list[float | None]]:
    return [[model.share(value, highest) for value, highest in zip(row, top, strict=True)] for row in returns]


def _stage(axis: worlds.Axis, group: groups.TaskGroup, task: int) -> str:
    """The name of the stage after a task: its value, or what the task is called."""
    trained = next((each for each in axis.trained if each.task == task and each.low == each.high), None)
    if trained is not None and axis.name == "gravity":
        return f"at {svg.tick_label(trained.low)} {axis.unit}"
    return group.tasks[task].name.removeprefix(group.tasks[task].base)


@dataclass(frozen=True)
class Landscapes:
    """The landscapes of all submissions of a site, as far as their folders are known."""

    folders: Mapping[str, Path] = field(default_factory=dict)

    @cached_property
    def _all(self) -> Mapping[str, Mapping[str, View]]:
        found = {name: model.landscapes_of(folder) for name, folder in sorted(self.folders.items())}
        standing = {}
        for name, landscapes in found.items():
            with suppress(BenchError):  # a submission with such a review has problems and is on no board
                if not review.is_withdrawn(review.read_review(self.folders[name]).decisions):
                    standing[name] = landscapes
        top = model.best(standing)
        known = {group.id: group for group in groups.GROUPS.values()}
        views: dict[str, dict[str, View]] = {id_: {} for id_ in known}
        for name, landscapes in found.items():
            # A withdrawn submission is compared on its own page alone.
            measured = standing | {name: landscapes}
            highest = top if name in standing else model.best(measured)
            for id_, each in landscapes.items():
                submissions = sum(id_ in others for others in measured.values())
                views[id_][name] = View(known[id_], each, highest, submissions)
        return views

    def views(self, submission: Scorecard) -> dict[str, View]:
        """The landscapes of a submission by group id, for its sequential results on groups with axes."""
        folder = self.folders.get(submission.name)
        if folder is None:
            return {}
        views = {}
        for group in groups.GROUPS.values():
            scores = submission.groups.get(group.id, {}).get(PROTOCOL)
            if scores is None or not worlds.axes(group):
                continue
            view = self._all[group.id].get(submission.name)
            if view is None:
                why = model.load(folder, group)
                if why == model.NOT_MEASURED and not any(run.policies for run in scores.provenance):
                    why = model.NO_POLICIES
                view = View(group, None, {}, why=str(why))
            views[group.id] = view
        return views

    def rows(self, board: BoardView) -> list[tuple[Row, View]]:
        """The submissions of a sequential board with a landscape, from the highest share to the lowest."""
        known = self._all.get(board.group, {}) if board.protocol == PROTOCOL else {}
        rows = [(row, known[row.submission.name]) for row in board.rows if row.submission.name in known]
        return sorted(rows, key=lambda pair: [-(value.mean or 0.0) for value in pair[1].summary.values()])

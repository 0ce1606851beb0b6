"""Landscapes on the pages: numbers of a submission, the submissions of a group side by side, and heat maps.

A map has worlds across and stages down, with the returns after the last stage below.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from itertools import groupby, pairwise
from pathlib import Path

from markupsafe import Markup

from gym_extensions.catalog import groups, worlds
from gym_extensions.errors import BenchError
from gym_extensions.metrics.values import MetricValue
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site.board_views import BoardView, Row
from gym_extensions.site.charts import svg
from gym_extensions.site.charts.svg import px
from gym_extensions.site.text import fixed, grouped
from gym_extensions.submissions import landscapes as model, review
from gym_extensions.submissions.landscapes import PROTOCOL, Landscape

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
    """The landscape of a submission on a group."""

    group: groups.TaskGroup
    landscape: Landscape
    best: model.Best
    submissions: int = 0  # that have a landscape of the group

    @cached_property
    def summary(self) -> dict[str, MetricValue]:
        """The shares of the best return: interpolation, if the group has such worlds, and extrapolation."""
        return model.summary(self.landscape, self.group, self.best)

    @property
    def axes(self) -> list[AxisView]:
        """Every axis, drawn."""
        views, tasks = [], range(len(self.group.tasks))
        for axis in worlds.axes(self.group):
            measured, best = self.landscape.axis(axis.name), self.best[self.group.id, axis.name]
            stages = ("untrained", *(_stage(axis, self.group, task) for task in tasks))
            runs = tuple(
                (run, small(axis, _shares(returns, best), f"Run {run}"))
                for run, returns in zip(self.landscape.runs, measured.returns, strict=True)
            )
            drawing = large(axis, measured, best, stages)
            views.append(AxisView(axis, stages, drawing, runs, measured.means))
        return views

    @property
    def maps(self) -> dict[str, Markup]:
        """A small map of the mean over runs, by what is varied."""
        maps = {}
        for axis in worlds.axes(self.group):
            means, best = self.landscape.axis(axis.name).means, self.best[self.group.id, axis.name]
            maps[axis.title] = small(axis, _shares(means, best), axis.title)
        return maps


def _shares(returns: Sequence[Sequence[float]], best: Sequence[float]) -> list[list[float | None]]:
    return [[model.share(value, top) for value, top in zip(row, best, strict=True)] for row in returns]


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

    def views(self, submission: Scorecard) -> dict[str, View | str]:
        """The landscapes of a submission by group id, or why there is none, as a sentence.

        They are those of its sequential results on groups with axes.
        """
        folder = self.folders.get(submission.name)
        if folder is None:
            return {}
        views = dict[str, View | str]()
        for group in groups.GROUPS.values():
            scores = submission.log(group.id, PROTOCOL)
            if scores is None or not worlds.axes(group):
                continue
            if view := self._all[group.id].get(submission.name):
                views[group.id] = view
                continue
            why = str(model.load(folder, group))
            if why == model.NOT_MEASURED and not any(run.policies for run in scores.provenance):
                why = model.NO_POLICIES
            views[group.id] = why
        return views

    def rows(self, board: BoardView) -> list[tuple[Row, View]]:
        """The submissions of a sequential board with a landscape, from the highest share to the lowest."""
        known = self._all.get(board.group, {}) if board.protocol == PROTOCOL else {}
        rows = [(row, known[row.submission.name]) for row in board.rows if row.submission.name in known]
        return sorted(rows, key=lambda pair: [-(value.mean or 0.0) for value in pair[1].summary.values()])


TINTS = 10
"""Steps of the tint, from 0 to the best return."""
LEFT, RIGHT, TOP, ROW = 76.0, 404.0, 18.0, 20.0
"""Edges of the map and height of a stage."""
GAP, PROFILE, BELOW = 14.0, 84.0, 32.0
"""Space below the map, height of the returns, and space for their ticks and title."""
SMALL_WIDTH, SMALL_ROW = 150.0, 10.0
TICK_DISTANCE = 21.0
"""Minimum distance of labels across."""
Shares = Sequence[Sequence[float | None]]
"""[stage][point] as a share of the best return; None where there is no share."""


@dataclass(frozen=True)
class Frame:
    """Where a map is: the scale across, the edges of the columns, its top and the height of a stage."""

    x: svg.Scale
    edges: tuple[float, ...]
    top: float
    row: float

    @classmethod
    def of(cls, axis: worlds.Axis, left: float, right: float, top: float, row: float) -> "Frame":
        """The frame of an axis; a column reaches halfway to its neighbours."""
        values = axis.points
        middles = [(low + high) / 2 for low, high in pairwise(values)]
        first, last = 2 * values[0] - middles[0], 2 * values[-1] - middles[-1]
        x = svg.Scale(first, last, left, right)
        return cls(x, tuple(map(x.at, (first, *middles, last))), top, row)

    def y(self, stage: float) -> float:
        """The upper edge of a stage."""
        return self.top + stage * self.row


def _map(axis: worlds.Axis, shares: Shares, frame: Frame, dots: tuple[float, float]) -> str:
    """The cells, one path per tint, and the trained values: large right after their stage, small later.

    Neighbours of one tint are one cell. Cells are strokes as wide as a stage, those of the most frequent tint
    a ground, and dots those of a dashed line, so that a page with many maps stays small.
    """
    cells: dict[str, list[str]] = {}
    for stage, row in enumerate(shares):
        tints = [
            "unknown" if share is None else f"t{round(TINTS * min(max(share, 0.0), 1.0))}" for share in row
        ]
        for kind, members in groupby(range(len(row)), key=tints.__getitem__):
            first, *others = members
            left, right = frame.edges[first], frame.edges[first + len(others) + 1]
            way = f"M{round(left)} {px(frame.y(stage + 0.5))}H{round(right)}"
            cells.setdefault(kind, []).append(way)
    ground = max(cells, key=lambda kind: len(cells[kind]))
    del cells[ground]  # the most frequent tint is one stroke below the others
    left, right, height = frame.edges[0], frame.edges[-1], frame.row * len(shares)
    whole = f"M{px(left)} {px(frame.top + height / 2)}H{px(right)}"
    drawn = "".join(f'<path class="{kind}" d="{"".join(ways)}"/>' for kind, ways in sorted(cells.items()))
    body = [f'<path class="{ground}" stroke-width="{px(height)}" d="{whole}"/>']
    body += [f'<g stroke-width="{frame.row:g}">{drawn}</g><g stroke-dasharray="0 {frame.row:g}">']
    for size, is_now in zip(dots, (False, True), strict=True):
        marks: list[str] = []
        for each in axis.trained:
            first = each.task + (1 if is_now else 2)
            last = first if is_now else len(shares) - 1
            marks += [
                f"M{px(frame.x.at(value))} {px(frame.y(first + 0.5))}v{px((last - first) * frame.row + 1)}"
                for value in axis.points
                if each.low <= value <= each.high and first <= last < len(shares)
            ]
        body += [
            f'<path class="{kind}" stroke-width="{width:g}" d="{"".join(marks)}"/>'
            for kind, width in (("halo", size + 2), ("seen", size))
            if marks
        ]
    return "".join([*body, "</g>"])


def small(axis: worlds.Axis, shares: Shares, label: str) -> Markup:
    """The map of one run, without ticks."""
    frame = Frame.of(axis, 0.0, SMALL_WIDTH, 0.0, SMALL_ROW)
    height = frame.y(len(shares))
    return svg.picture("landscape small", SMALL_WIDTH, height, label, _map(axis, shares, frame, (2, 5)))


def large(
    axis: worlds.Axis, measured: model.MeasuredAxis, best: Sequence[float], stages: Sequence[str]
) -> Markup:
    """The map of the mean over runs, and the returns of the runs after the last stage below it.

    ``best`` has the best mean return at every point, ``stages`` the name of every stage.
    """
    means, returns = measured.means, [run[-1] for run in measured.returns]
    mean, shares = means[-1], _shares(means, best)
    frame = Frame.of(axis, LEFT, RIGHT, TOP, ROW)
    bottom = frame.y(len(shares))
    low = bottom + GAP + PROFILE
    y = svg.scale_around(
        [*best, *(value for run in returns for value in run)], low, bottom + GAP, always=(0.0,)
    )
    body = [_map(axis, shares, frame, (3, 7.5))]
    body.append(svg.text("tick side", LEFT - 6, TOP - 7, "after training"))
    body += [svg.text("tick side", LEFT - 6, frame.y(at + 0.5) + 3.5, name) for at, name in enumerate(stages)]
    trained = [value for value in axis.points if axis.place(value) == "trained"]
    body += [svg.stroke(frame.x.at(at), bottom + 3, frame.x.at(at), low, "level") for at in trained]
    body += [svg.stroke(LEFT, y.at(at), RIGHT, y.at(at), "level") for at in y.ticks(3)]
    body += [
        svg.text("tick side", LEFT - 6, y.at(at) + 3.5, grouped(round(at)))
        for at in svg.apart(y.ticks(3), y)
        if y.at(at) > bottom + GAP + 12
    ]
    across = list(axis.points)
    for kind, line in (*(("thin", run) for run in returns), ("best", best), ("bold", mean)):
        body.append(
            f'<polyline class="{kind}" points="{svg.points(zip(across, line, strict=True), frame.x, y)}"/>'
        )
    body.append(svg.text("tick side", LEFT - 6, bottom + GAP + 2, "return"))
    body += _ticks(axis, frame, trained, low + 13)
    body.append(svg.text("tick", (LEFT + RIGHT) / 2, low + 28, f"{axis.title} ({axis.unit})"))
    return svg.picture("landscape", RIGHT + 6, low + BELOW, describe(axis, mean, best), "".join(body))


def _ticks(axis: worlds.Axis, frame: Frame, trained: Sequence[float], y: float) -> list[str]:
    """Labels of the trained values in bold, and of both ends, where they do not overlap."""
    placed: list[float] = []
    labels = []
    for value in (axis.points[0], axis.points[-1], trained[0], trained[-1], *trained):
        at = frame.x.at(value)
        if all(abs(at - other) >= TICK_DISTANCE for other in placed):
            placed.append(at)
            labels.append(svg.text("tick key" if value in trained else "tick", at, y, svg.tick_label(value)))
    return labels


def describe(axis: worlds.Axis, mean: Sequence[float], best: Sequence[float]) -> str:
    """The returns after the last stage in words: at both ends and at the trained values."""
    parts = [
        f"{fixed(at, 0)} at {svg.tick_label(value)} {axis.unit}{' (trained)' if is_trained else ''}, "
        f"best of all submissions {fixed(top, 0)}"
        for value, at, top in zip(axis.points, mean, best, strict=True)
        if (is_trained := axis.place(value) == "trained") or value in (axis.points[0], axis.points[-1])
    ]
    return f"Mean return after the last stage by {axis.title}: {'; '.join(parts)}"


def scale() -> Markup:
    """The legend of the tint."""
    width = 14
    cells = "".join(
        f'<path class="t{tint}" stroke-width="10" d="M{tint * width} 5h{width}"/>'
        for tint in range(TINTS + 1)
    )
    return svg.picture("landscape tints", width * (TINTS + 1), 10, "", cells)

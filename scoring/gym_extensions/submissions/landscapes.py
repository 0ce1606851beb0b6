"""Landscapes: the returns of a submission's policies in worlds between and beyond those that it was trained
in.

``gym-extensions maintain landscapes`` measures them and writes ``landscapes/<group>.json`` into the
submission's folder. Loads no simulator.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import Annotated, Literal

from gym_extensions.catalog.groups import GROUPS, TaskGroup
from gym_extensions.catalog.worlds import Axis, Place, axes
from gym_extensions.documents import JsonDocument, about
from gym_extensions.metrics.statistics import interval, mean
from gym_extensions.metrics.values import MetricValue
from gym_extensions.submissions.layout import DOCUMENT, LANDSCAPES, run_file
from gym_extensions.submissions.run import RunDocument, read_run
from gym_extensions.submissions.submission import runs_folder

PROTOCOL = "sequential"
RUNS = 5
"""The runs 0 to 4 are measured."""
EPISODES = 10
"""Episodes at every point, on the same seeds for all points, stages, runs and submissions."""
INTERPOLATION, EXTRAPOLATION = "interpolation", "extrapolation"
SHARES: dict[str, Place] = {INTERPOLATION: "between", EXTRAPOLATION: "beyond"}
"""What is stated of a submission, and the worlds of which it is the mean."""
NOT_MEASURED = "Not measured yet."
NO_POLICIES = "It is measured with the policies of the runs, and they are not published."
OTHER_RUNS = "The policies of its runs have changed since it was measured."
OTHER_VALUES = "It was measured at other values than those of this version."
Values = tuple[tuple[tuple[float, ...], ...], ...]
"""[run][stage][point]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredAxis:
    """The returns along one axis."""

    name: Annotated[str, about("`gravity`, a part of the body, or `wall`")]
    points: Annotated[tuple[float, ...], about("the values, ascending")]
    returns: Annotated[Values, about("mean returns of the episodes by run, stage and point")]
    deviations: Annotated[Values, about("their standard deviations over episodes (divisor n)")]

    @property
    def means(self) -> tuple[tuple[float, ...], ...]:
        """Mean returns over runs by stage and point."""
        stages = zip(*self.returns, strict=True)
        return tuple(tuple(map(fmean, zip(*runs, strict=True))) for runs in stages)


@dataclass(frozen=True, slots=True, kw_only=True)
class Landscape(JsonDocument):
    """The landscape of a submission on a group."""

    format: Annotated[Literal[1], about("1")] = 1
    group: Annotated[str, about("group id")]
    episodes: Annotated[int, about("number of episodes at every point")]
    policies: Annotated[dict[str, str], about("digest of the policies of every run, by run")]
    versions: Annotated[
        dict[str, str],
        about("of packages, and the arithmetic of policies; older files name the BLAS kernels instead"),
    ]
    axes: Annotated[tuple[MeasuredAxis, ...], about("what is varied")]

    @property
    def runs(self) -> tuple[int, ...]:
        """The runs, in the order of the returns."""
        return tuple(map(int, self.policies))

    def axis(self, name: str) -> MeasuredAxis:
        """The returns along the axis of that name."""
        return next(each for each in self.axes if each.name == name)


def path_of(submission: Path, group: TaskGroup) -> Path:
    """The file of a group's landscape in a submission's folder."""
    return submission / LANDSCAPES / f"{group.name}.json"


def measured_runs(submission: Path, group: TaskGroup) -> dict[int, RunDocument]:
    """The documents of the runs that are measured, as far as the submission has them."""
    runs = runs_folder(submission, group.name, PROTOCOL)
    paths = {run: runs / run_file(group.name, PROTOCOL, run, DOCUMENT) for run in range(RUNS)}
    return {run: read_run(path) for run, path in paths.items() if path.is_file()}


def load(submission: Path, group: TaskGroup) -> Landscape | str:
    """The landscape of a submission on a group with axes, or the reason why there is none, as a sentence.

    Raises ``BenchError`` if a file cannot be read.
    """
    found = Landscape.load(path_of(submission, group), "bad-landscape", "gym-extensions maintain landscapes")
    if found is None:
        return NOT_MEASURED
    documents = measured_runs(submission, group).items()
    if found.policies != {str(run): each.policies.sha256 for run, each in documents if each.policies}:
        return OTHER_RUNS
    along = [(each.name, each.points) for each in axes(group)]
    return found if [(each.name, each.points) for each in found.axes] == along else OTHER_VALUES


Best = Mapping[tuple[str, str], tuple[float, ...]]
"""By group id and axis, the best mean return at every point over all submissions and stages."""


def best(submissions: Mapping[str, Mapping[str, Landscape]]) -> Best:
    """The best mean return over runs at every point, of any stage of any landscape of these submissions."""
    found: dict[tuple[str, str], tuple[float, ...]] = {}
    for landscape in (each for landscapes in submissions.values() for each in landscapes.values()):
        for axis in landscape.axes:
            key = landscape.group, axis.name
            highest = tuple(map(max, zip(*axis.means, strict=True)))
            found[key] = tuple(map(max, highest, found.get(key, highest)))
    return found


def share(value: float, best: float) -> float | None:
    """A return as a share of the best one in its world; None where even that is not above 0."""
    return value / best if best > 0 else None


def summary(landscape: Landscape, group: TaskGroup, best: Best) -> dict[str, MetricValue]:
    """Interpolation and extrapolation: mean shares of the best after the last stage, over runs.

    A run's value is the mean over the worlds of all axes that lie between trained values (interpolation) or
    beyond them (extrapolation). A group without such worlds lacks the name.
    """
    along = axes(group)
    return {
        name: _over_runs(landscape, along, place, best)
        for name, place in SHARES.items()
        if any(axis.indices(place) for axis in along)
    }


def _over_runs(landscape: Landscape, along: tuple[Axis, ...], place: Place, best: Best) -> MetricValue:
    values = []
    for run in range(len(landscape.runs)):
        shares = (
            share(landscape.axis(axis.name).returns[run][-1][at], best[landscape.group, axis.name][at])
            for axis in along
            for at in axis.indices(place)
        )
        if (value := mean(each for each in shares if each is not None)) is not None:
            values.append(value)
    if not values:
        return MetricValue(why="No submission has a return above 0 in these worlds.")
    return MetricValue.of(interval(values), values)


def landscapes_of(submission: Path) -> dict[str, Landscape]:
    """The landscapes in a submission's folder that belong to its present runs, by group id."""
    names = (path.stem for path in sorted((submission / LANDSCAPES).glob("*.json")))
    found = {GROUPS[name].id: load(submission, GROUPS[name]) for name in names if name in GROUPS}
    return {group: each for group, each in found.items() if isinstance(each, Landscape)}

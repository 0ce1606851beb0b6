"""What an entry keeps of each task: scores after every stage, and the change since its training."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from gym_extensions.scoring.metrics.value import MetricValue
from gym_extensions.scoring.scorecard.model import GroupScore, ReferenceValue
from gym_extensions.scoring.statistics.intervals import interval

Stages = tuple[tuple[MetricValue, ...], ...]


@dataclass(frozen=True, slots=True)
class Change:
    """The change of a task's score since right after its training, over runs.

    Args:
        value: mean and interval; normalized, or a raw return where the task has no ceiling.
        normalized: whether it is normalized.
    """

    value: MetricValue
    normalized: bool

    @property
    def is_certain(self) -> bool:
        """Whether its interval excludes 0. A single run has no interval, and is not certain."""
        ends = self.value.ends
        return ends is not None and not ends[0] <= 0 <= ends[1]


@dataclass(frozen=True)
class Retention:
    """One entry on one group, from its sequential scores."""

    score: GroupScore

    @property
    def tasks(self) -> tuple[str, ...]:
        """Task ids in training order."""
        return self.score.tasks

    @cached_property
    def changes(self) -> tuple[Change, ...]:
        """Per task but the last, which nothing follows; empty without a return matrix."""
        if not self.score.return_matrix:
            return ()
        references = map(self.score.reference.get, self.tasks[:-1])
        return tuple(_change(self.score, at, reference) for at, reference in enumerate(references))

    @cached_property
    def stages(self) -> Stages:
        """``[stage][task]`` scores after every stage; without a value where the task has no ceiling."""
        if not self.score.return_matrix:
            return ()
        references = [self.score.reference.get(task) for task in self.tasks]
        return tuple(
            tuple(_score(self.score, stage, at, reference) for at, reference in enumerate(references))
            for stage in range(len(self.tasks) + 1)
        )


def _normalized(values: list[float], reference: ReferenceValue | None) -> list[float] | None:
    shares = [reference.normalize(value) for value in values] if reference else [None]
    present = [share for share in shares if share is not None]
    return present if len(present) == len(values) else None


def _change(score: GroupScore, at: int, reference: ReferenceValue | None) -> Change:
    after = [run[at + 1][at] for run in score.return_matrix]
    end = [run[-1][at] for run in score.return_matrix]
    before, final = _normalized(after, reference), _normalized(end, reference)
    normalized = before is not None and final is not None
    pairs = zip(before or after, final or end, strict=True) if normalized else zip(after, end, strict=True)
    return Change(MetricValue.of(interval([later - first for first, later in pairs])), normalized)


def _score(score: GroupScore, stage: int, at: int, reference: ReferenceValue | None) -> MetricValue:
    values = _normalized([run[stage][at] for run in score.return_matrix], reference)
    return MetricValue() if values is None else MetricValue.of(interval(values))

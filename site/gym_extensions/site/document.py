"""The scorecard document as typed values: the one place that knows its keys."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from gym_extensions.scoring.leaderboard.board import LEAST_LEARNED

Json = Mapping[str, Any]
FORMAT = 1
Profile = tuple[tuple[float, float], ...]
"""Points of (score, share of runs and tasks above it), by score."""


@dataclass(frozen=True)
class Estimate:
    """A metric over runs: the mean, its 95 % interval and one value a run; or nothing, and ``why``."""

    mean: float | None = None
    low: float | None = None
    high: float | None = None
    runs: tuple[float, ...] = ()
    why: str = ""

    @property
    def ends(self) -> tuple[float, float] | None:
        """Both ends of the interval, or None with fewer than two runs."""
        return None if self.low is None or self.high is None else (self.low, self.high)


@dataclass(frozen=True)
class Spread:
    """Mean and population standard deviation of pooled episodes."""

    mean: float
    std: float


@dataclass(frozen=True)
class Reference:
    """A task's frozen floor and ceiling; an open task has no ceiling."""

    floor: float | None
    ceiling: float | None
    open: bool

    def normalise(self, value: float) -> float | None:
        """(value − floor) / (ceiling − floor), not clipped; None for an open task."""
        if self.open or self.floor is None or self.ceiling is None or self.ceiling == self.floor:
            return None
        return (value - self.floor) / (self.ceiling - self.floor)


@dataclass(frozen=True)
class Version:
    """The references that all scores stand on: name, whether they are provisional, digest of their file."""

    name: str
    provisional: bool
    sha256: str


@dataclass(frozen=True)
class Curve:
    """One training curve: points of (training step, mean return of the episodes ended since the last one)."""

    run: int
    task: str
    points: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Trial:
    """What one submission did on one group under one protocol.

    ``matrix[run][stage][task]`` holds mean raw returns, stage 0 first; protocols without stages have
    ``returns[run][task]`` in its place. ``missing`` names what a full entry still needs; ``printed`` holds
    a publication's own totals beside the recomputed ones, ``notes`` what contradicts itself in it. A suite
    has metrics alone. ``profile`` and ``iqm`` (interquartile mean) describe the scores at the end, over runs
    and tasks; a profile is empty where every task is open.
    """

    group: str
    protocol: str
    budget: str
    runs: tuple[int, ...]
    tasks: tuple[str, ...]
    metrics: Mapping[str, Estimate]
    table: tuple[tuple[str, Mapping[str, Spread | None]], ...]
    total: Mapping[str, Spread | None]
    references: Mapping[str, Reference]
    matrix: tuple[tuple[tuple[float, ...], ...], ...]
    returns: tuple[tuple[float, ...], ...]
    curves: tuple[Curve, ...]
    missing: tuple[str, ...] = ()
    printed: Mapping[str, Spread | None] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    profile: Profile = ()
    iqm: float | None = None

    def metric(self, name: str) -> Estimate:
        """The named metric; one that the document lacks is empty and says so."""
        return self.metrics.get(name, Estimate(why="not part of this protocol"))

    @property
    def id(self) -> str:
        """Its anchor on the submission's page."""
        return f"{self.group}-{self.protocol}"

    @property
    def learned_nothing(self) -> bool:
        """Whether it could forget nothing: the interval of learning performance does not lie above 0.

        With one run, which has no interval: the value is below .1 (docs/metrics.md, "How boards are read").
        """
        learning = self.metric("learning_performance")
        if learning.mean is None:
            return False
        return learning.mean < LEAST_LEARNED if learning.ends is None else learning.ends[0] <= 0

    @property
    def nothing_at_all(self) -> str:
        """The one reason why every metric is missing, or nothing where one has a value or reasons differ."""
        reasons = {found.why if found.mean is None else "" for found in self.metrics.values()}
        return next(iter(reasons)) if len(reasons) == 1 else ""

    @property
    def open_tasks(self) -> tuple[str, ...]:
        """The tasks that no reference agent has learned, in training order."""
        return tuple(task for task in self.tasks if task in self.references and self.references[task].open)


@dataclass(frozen=True)
class Problem:
    """A rule that a submission breaks: where, what was found, what to do."""

    rule: str
    where: str
    message: str
    hint: str


@dataclass(frozen=True)
class Entry:
    """One submission; ``manifest`` holds what its ``submission.toml`` says, by its own keys."""

    name: str
    title: str
    trust: str
    problems: tuple[Problem, ...] = ()
    manifest: Json = field(default_factory=dict)
    trials: tuple[Trial, ...] = ()
    notes: tuple[str, ...] = ()
    suites: tuple[Trial, ...] = ()

    def knows(self, what: str) -> bool | None:
        """Whether the agent is told that (a key of ``[observes]``); None when the manifest does not say."""
        told: bool | None = self.manifest.get("observes", {}).get(what)
        return told

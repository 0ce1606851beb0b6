"""Records: policies that beat the expert of a task. Their files, their bar and their reviews. No simulator.

``records/<task>/<name>.npz`` is the policy, ``<name>.json`` its card (a submitter writes both), and
``<name>.review.json`` what new seeds showed, which is written on the base branch.
"""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Literal

from gym_extensions.catalog.tasks import Task, mujoco_tasks, task
from gym_extensions.documents import JsonDocument, about
from gym_extensions.errors import BenchError
from gym_extensions.files import write_text
from gym_extensions.references import measured
from gym_extensions.references.experts import MAX_CARD, Measurement, RecordCard, floor_margin, read_card
from gym_extensions.submissions.layout import MEBIBYTE, read_regular
from gym_extensions.submissions.poses import TaskPoses
from gym_extensions.submissions.review import Count, Date, Sha256, Text, Value

RECORDS = "records"
CARD, POLICY, REVIEW = ".json", ".npz", ".review.json"
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}")
"""The name of a record."""
EPISODES = 100
"""New episodes of a verification, and the fewest of a claim."""
STANDARD_ERRORS = 3.0
"""How far a record's mean must lie above the expert's, in standard errors of the difference."""
BELOW_CLAIM = 2.65
"""How far it may lie below the claimed mean: an honest claim lies further above it once in 250 times."""
MAX_REVIEW = MEBIBYTE


def recordable(name: str) -> Task | None:
    """The published MuJoCo task with this bare name, which can have records; None if there is none."""
    return next((row for row in mujoco_tasks() if row.bare_name == name), None)


@dataclass(frozen=True)
class Bar:
    """What a record must beat: the expert's mean with its standard error, or on an open task the floor.

    ``floor_deviation`` is the standard deviation of the floor agent's episodes; None if there is an expert.
    """

    mean: float
    standard_error: float = 0.0
    floor_deviation: float | None = None

    def least(self, standard_error: float) -> float:
        """What a mean return with this standard error must exceed."""
        if self.floor_deviation is None:
            return self.mean + STANDARD_ERRORS * math.hypot(standard_error, self.standard_error)
        return self.mean + floor_margin(standard_error, self.floor_deviation)


def bar(row: Task) -> Bar:
    """What a record of a task must beat. Raises ``BenchError`` if the task has no references."""
    found = measured().get(row.id)
    if found is None:
        message = f"{row.name} has no references, so no policy can be a record."
        raise BenchError("missing-reference", message, row.name, "Choose another task.")
    if found.expert is not None:
        return Bar(found.expert.mean, found.expert.standard_error)
    return Bar(found.floor.mean, floor_deviation=found.floor.agents[found.floor.agent].std)


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordReview(JsonDocument):
    """What the verification of a record found: returns on seeds that nobody knew when it was submitted."""

    format: Annotated[Literal[1], about("1")] = 1
    card: Annotated[Sha256, about("SHA-256 of the card, which has the digest of the policy")]
    date: Annotated[Date, about("the day (ISO)")]
    version: Annotated[Text, about("of gym_extensions")]
    value: Annotated[Value, about("hexadecimal digits from which the new seeds follow")]
    episodes: Annotated[Count, about("episodes on new seeds")]
    mean: Annotated[float, about("of their returns")]
    deviation: Annotated[float, about("standard deviation of their returns")]
    least: Annotated[float, about("what the mean must exceed: the expert's, with a margin")]
    problem: Annotated[Text, about("why it is no record; empty if it is one")]
    poses: Annotated[TaskPoses | None, about("the episode of the median return; null if it was not run")]

    @property
    def measurement(self) -> Measurement:
        """The new returns."""
        return Measurement(self.episodes, self.mean, self.deviation)


@dataclass(frozen=True)
class Record:
    """A record in a folder, by the path of its card; nothing is read before it is used."""

    path: Path

    @property
    def name(self) -> str:
        """``Hopper/name``."""
        return f"{self.path.parent.name}/{self.path.stem}"

    @property
    def task(self) -> Task:
        """Its task. Raises ``BenchError`` if there is none of that name."""
        return task(self.path.parent.name)

    @property
    def policy_path(self) -> Path:
        """The file of the policy."""
        return self.path.with_suffix(POLICY)

    @cached_property
    def card(self) -> RecordCard:
        """The card. Raises ``BenchError`` as :func:`read_card` does, and for a claim of too few episodes."""
        found = read_card(self.path, self.path.parent.name, RecordCard)
        if found.measurement.episodes < EPISODES or not found.history:
            message = f"The claim needs {EPISODES} episodes, and the history a training run."
            raise BenchError("bad-card", message, str(self.path))
        return found

    @property
    def digest(self) -> str:
        """SHA-256 of the card's bytes."""
        return hashlib.sha256(read_regular(self.path, MAX_CARD)).hexdigest()

    @cached_property
    def review(self) -> RecordReview | None:
        """The review of the files as they are; None if there is none."""
        path = self.path.with_suffix(REVIEW)
        found = read_record_review(path) if path.exists() else None
        return found if found and found.card == self.digest else None

    @property
    def verified(self) -> bool:
        """Whether its review found no problem."""
        return self.review is not None and not self.review.problem

    def write(self, review: RecordReview, path: Path | None = None) -> None:
        """Writes the review, by default beside the card, whole or not at all."""
        write_text(path or self.path.with_suffix(REVIEW), review.to_json())


def problem_of(card: RecordCard, bar: Bar, seen: Measurement) -> str:
    """Why episodes on new seeds show no record; empty if they do.

    Their deviation also serves for the returns of the claim, so that a claim cannot hide behind a large one.
    """
    claim, least = card.measurement, bar.least(seen.standard_error)
    margin = BELOW_CLAIM * seen.deviation * math.sqrt(1 / claim.episodes + 1 / seen.episodes)
    if seen.mean < claim.mean - margin - 1e-6 * abs(claim.mean):
        return f"It returns {seen.mean:.1f} on new seeds; the card claims {claim.mean:.1f}."
    if not seen.mean > least:
        goal = f"the {'expert' if bar.floor_deviation is None else 'floor'}, {bar.mean:.1f}"
        return f"It returns {seen.mean:.1f}; to beat {goal}, it needs more than {least:.1f}."
    return ""


def read_record_review(path: Path) -> RecordReview:
    """The review in a file, strictly: as the command writes it, with a motion that can be drawn.

    Raises ``BenchError`` if it is not such a file.
    """
    try:
        data = read_regular(path, MAX_REVIEW)
        review = RecordReview.from_json(data)
        if review.to_json().encode() != data or review.episodes < 2:
            raise ValueError("it is not as gym-extensions verify writes it")
        if review.poses is not None:
            review.poses.after.coordinates(review.poses.unit)
    except (OSError, ValueError, RecursionError, BenchError) as error:
        raise BenchError("bad-review", f"It is not the review of a record: {error}.", str(path)) from error
    return review


def records_in(folder: Path) -> list[Record]:
    """The records in a folder ``records``, or in that of one of its tasks, by name."""
    policies = folder.glob("*/*.npz") if folder.name == RECORDS else folder.glob("*.npz")
    return [Record(path.with_suffix(CARD)) for path in sorted(policies)]


def verified_records(folder: Path) -> dict[str, tuple[Record, ...]]:
    """The verified records in a folder ``records`` by task id, the highest mean on new seeds first."""
    found: dict[str, list[Record]] = {}
    for record in records_in(folder):
        if record.verified:
            found.setdefault(record.card.task, []).append(record)
    return {name: tuple(sorted(each, key=_rank)) for name, each in found.items()}


def _rank(record: Record) -> float:
    return -record.review.mean if record.review else math.inf


def split_paths(paths: Iterable[Path]) -> tuple[list[Record], list[Path]]:
    """The records that paths mean, and the other paths.

    A folder ``records`` means all of its records, ``records/Hopper`` those of a task, and
    ``records/Hopper/name``, with or without the suffix of a file, one.
    """
    records: list[Record] = []
    others: list[Path] = []
    for path in paths:
        whole = path.resolve()
        if whole.name == RECORDS or (whole.parent.name == RECORDS and recordable(whole.name)):
            records += records_in(whole)
        elif whole.parent.parent.name == RECORDS and recordable(whole.parent.name):
            records.append(Record(whole.with_name(whole.name.partition(".")[0] + CARD)))
        else:
            others.append(path)
    return records, others

"""Records: makes their files, and runs them on new seeds. A policy runs in the process with limits."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import numpy as np

from gym_extensions.catalog import fingerprints
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.tasks import Task, task
from gym_extensions.envs.rollout import Outcome
from gym_extensions.errors import BenchError
from gym_extensions.files import write_text
from gym_extensions.references import experts
from gym_extensions.references.experts import Measurement, RecordCard, Step, described_policy
from gym_extensions.scoring import records
from gym_extensions.submissions.layout import POSES
from gym_extensions.submissions.policies.mlp import Policy
from gym_extensions.submissions.poses import Clip, PolicyPoses, TaskPoses
from gym_extensions.verification.episodes import Cell
from gym_extensions.verification.limits import Limits, answers
from gym_extensions.verification.new_seeds import Draw
from gym_extensions.verification.pose_recorder import (
    FRAMES,
    Array,
    motion,
    recorded,
    shown_episode,
    timing_of,
)
from gym_extensions.versions import version

JOB = "gym_extensions.verification.verify_record:play"
LIMITS = Limits(cpu_seconds=1800, wall_seconds=7200)
"""Of the process that runs a record: 100 episodes take a few seconds, those of the Humanoid half a minute."""
T = TypeVar("T")
SAMPLE, SAMPLE_ERRORS = 20, 5.0
"""Episodes of a first look, and how far their mean may lie below the claim, in standard errors."""


def outcomes(policy: Policy, row: Task, seeds: Sequence[int]) -> tuple[list[Outcome], list[list[Array]]]:
    """One episode per seed, in this process, and the coordinates in the first seconds of each.

    Raises ``BenchError`` if the policy samples its actions, depends on a task of a group, or does not fit.
    """
    if policy.head != "deterministic" or policy.num_tasks:
        message = "The policy samples its actions, or has arrays per task of a group."
        raise BenchError("bad-policy", message, row.name, "Give a deterministic policy of the one task.")
    group = TaskGroup("record", (row,))
    return recorded(group, policy, Cell(1, 0, tuple(seeds)), timing_of(row))


def measurement(results: Sequence[Outcome]) -> Measurement:
    """Mean, standard deviation and successes of episodes."""
    returns = np.array([each.return_ for each in results])
    successes = [each.success for each in results if each.success is not None]
    share = float(np.mean(successes)) if successes else None
    return Measurement(len(returns), float(returns.mean()), float(returns.std(ddof=1)), share)


def played(policy: Policy, row: Task, seeds: Sequence[int]) -> tuple[Measurement, TaskPoses]:
    """As :func:`outcomes`, measured, and the poses of the episode with the median return."""
    results, tracks = outcomes(policy, row, seeds)
    returns, timing = [each.return_ for each in results], timing_of(row)
    episode = shown_episode(returns)
    clip = Clip(
        stage=1,
        episode=episode,
        returns=tuple(round(value, 2) for value in returns),
        **motion(tracks[episode], results[episode], timing),
    )
    frames = {name: getattr(timing, name) for name in FRAMES}
    return measurement(results), TaskPoses(task=row.id, after=clip, end=None, **frames)


def play(call: Mapping[str, Any]) -> Iterator[Any]:
    """The job of the process with limits: the measurement of a record, and the poses of an episode."""
    record = records.Record(Path(call["card"]))
    policy = described_policy(record.policy_path, record.card)
    yield msgspec.to_builtins(played(policy, record.task, call["seeds"]))


def write_expert_poses(names: Sequence[str], folder: Path = experts.DATA) -> Iterator[str]:
    """Writes the poses of experts that have none of their present policy, and yields a line for each expert.

    They are in the folder ``poses`` of that of the experts' files. Raises ``BenchError`` without an expert.
    """
    for name in names:
        row, policy = task(name), experts.load(name, folder)
        path, digest = folder / POSES / f"{name}.json", experts.digest(policy)
        known = PolicyPoses.load(path, "bad-poses", "gym-extensions maintain poses")
        if known is None or known.policy != digest:
            seeds = measurement_seeds(row, SAMPLE)
            poses = PolicyPoses(policy=digest, poses=played(policy, row, seeds)[1])
            write_text(path, poses.to_json())
            yield str(path)
        else:
            yield f"{path}: up to date"


def verify_record(record: records.Record, value: str) -> records.RecordReview:
    """The review of a record on new seeds, which follow from the card and 40 to 128 hexadecimal digits.

    Raises:
        BenchError: card or policy cannot be read or do not fit the task, a limit was reached, or the floor
            of the task was not measured.
    """
    if not record.path.is_file():
        message = "There is no such file."
        raise BenchError("no-such-record", message, str(record.path), "Name a record's card.")
    needed, draw = records.bar(record.task), Draw(record.digest, value)
    seeds = [draw.seed(records.RECORDS, record.task.id, index) for index in range(records.EPISODES)]
    (answer,) = answers(JOB, {"card": str(record.path.resolve()), "seeds": seeds}, LIMITS)
    seen, poses = msgspec.convert(answer, tuple[Measurement, TaskPoses])
    return records.RecordReview(
        card=record.digest,
        date=datetime.now(UTC).date().isoformat(),
        version=version("gym-extensions"),
        value=value,
        episodes=seen.episodes,
        mean=seen.mean,
        deviation=seen.deviation,
        least=needed.least(seen.standard_error),
        problem=records.problem_of(record.card, needed, seen),
        poses=poses,
    )


def sample(record: records.Record) -> tuple[int, list[BenchError]]:
    """Runs the first measurement episodes of a record in this process, for a first look at its claim.

    Returns their number, and what is wrong with the files, the claim, and how the policy fits the task.
    """
    errors: list[BenchError] = []

    def found(part: Callable[[], T]) -> T | None:
        try:
            return part()
        except BenchError as error:
            errors.append(error)
            return None

    row, path = record.task, record.policy_path
    card = found(lambda: record.card)
    policy = found(lambda: described_policy(path, card) if card else experts.read_policy(path))
    needed = found(lambda: records.bar(row))
    seeds = measurement_seeds(row, SAMPLE)
    seen = found(lambda: measurement(outcomes(policy, row, seeds)[0])) if policy else None
    if card and needed and seen:
        claim = card.measurement
        problem = records.problem_of(card, needed, claim)
        if seen.mean < claim.mean - SAMPLE_ERRORS * seen.standard_error - 1e-6 * abs(claim.mean):
            problem = f"It returns {seen.mean:.1f} in {SAMPLE} episodes; the card claims {claim.mean:.1f}."
        errors += [BenchError("no-record", problem)] if problem else []
    return (seen.episodes if seen else 0), errors


def measurement_seeds(row: Task, count: int) -> list[int]:
    """The seeds of the first measurement episodes of a task."""
    return [experts.seed(row, "measure", index) for index in range(count)]


def line_of(record: records.Record, review: records.RecordReview) -> str:
    """The review in words."""
    error = review.measurement.standard_error
    seen = f"{review.mean:.1f} ± {error:.1f} over {review.episodes} new episodes"
    verdict = "NOT a record" if review.problem else "a record"
    return f"{record.name}: {verdict}, {seen}. {review.problem}".rstrip()


def write_record(
    policy: Policy,
    task_name: str,
    name: str,
    *,
    authors: Sequence[str],
    history: Sequence[Step],
    folder: Path | str = records.RECORDS,
) -> Path:
    """Measures a policy on the measurement seeds of its task and writes both files of a record.

    Args:
        policy: a deterministic policy; its noise is switched off.
        task_name: bare name of a published MuJoCo task.
        name: of the record: up to 64 letters, digits, dashes and underscores.
        authors: names of the authors.
        history: the training runs, the first one first.
        folder: of all records.

    Returns:
        The path of the card.

    Raises:
        BenchError: the task cannot have records, the name is none, the policy does not fit the task, or its
            mean would not pass. Nothing is written then.
    """
    row = records.recordable(task_name)
    if row is None or not records.NAME.fullmatch(name):
        message = f"{task_name!r} is no MuJoCo task, or {name!r} no name of a record."
        raise BenchError("bad-record", message, hint="Take the bare name of a task, such as Hopper.")
    path = Path(folder) / row.bare_name / f"{name}{records.CARD}"
    if path.exists():
        raise BenchError("name-taken", "There is such a record.", str(path), "Take another name.")
    policy = replace(policy, head="deterministic")
    results, _ = outcomes(policy, row, measurement_seeds(row, records.EPISODES))
    card = RecordCard(
        task=row.id,
        fingerprint=fingerprints.published(row.id),
        policy=experts.digest(policy),
        history=tuple(history),
        measurement=measurement(results),
        authors=(authors,) if isinstance(authors, str) else tuple(authors),
    )
    try:
        msgspec.convert(msgspec.to_builtins(card), RecordCard)
    except msgspec.ValidationError as error:
        raise BenchError("bad-card", f"{error}.", name, "Name up to 20 authors.") from error
    if problem := records.problem_of(card, records.bar(row), card.measurement):
        raise BenchError("no-record", problem, path.stem)
    experts.write_described(policy, card, path)
    return path

"""Published experts: written with their cards, measured again, and what pages show of them."""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import msgspec
import numpy as np

from gym_extensions.catalog import fingerprints
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.tasks import Task, mujoco_tasks, task as published_task
from gym_extensions.documents import filled
from gym_extensions.errors import BenchError
from gym_extensions.files import write_bytes
from gym_extensions.references import experts, load_references
from gym_extensions.references.experts import ExpertCard, seed
from gym_extensions.submissions import poses
from gym_extensions.submissions.layout import POSES
from gym_extensions.submissions.policies.mlp import Policy
from gym_extensions.verification import pose_recorder
from gym_extensions.verification.episodes import Cell
from tools.experts.candidates import (
    QUICK,
    SCREENING,
    STORED,
    Workplace,
    episodes,
    history,
    summary,
    write_policy,
)
from tools.experts.recipes import FAMILIES, meant

DIFFERS = " (differs)"


def publish(work: Workplace, task: Task, count: int) -> str:
    """Measures the selected candidate on ``count`` seeds and writes its policy and card; returns a line.

    Nothing is written if no candidate has 100 selection episodes.
    """
    candidate, selection = work.best(task), work.candidates(task)
    if candidate is None or selection[candidate].episodes < QUICK:
        return f"{task.name} none"
    measurement = work.evaluate(candidate, task, "measure", count)
    row, policy = work.returns(candidate, task, "measure"), work.policy(candidate, task)
    steps = history(work, candidate)
    card = ExpertCard(
        task=task.id,
        fingerprint=fingerprints.published(task.id),
        policy=experts.digest(policy),
        history=steps,
        from_submission=any(step.name.startswith(STORED) for step in steps),
        candidates=len(selection),
        steps_tried=work.steps_tried(task),
        selection=selection[candidate],
        measurement=measurement,
        first_hundred=summary(row, QUICK).mean,
        provisional=meant(task, np.array(row["returns"])),
    )
    write_expert(policy, card, experts.DATA / f"{task.bare_name}.json")
    return f"{task.name} {card.measurement.mean:.1f} {card.provisional}"


def write_expert(policy: Policy, card: ExpertCard, path: Path) -> None:
    """Writes an expert and its card, the card last, so that a half-written pair cannot be loaded.

    Raises:
        BenchError: the card describes another policy, or a measurement is not finite.
    """
    if experts.digest(policy) != card.policy:
        raise BenchError("other-policy", "The card describes another policy.", str(path))
    if not math.isfinite(card.measurement.mean + card.selection.mean):
        raise BenchError("bad-card", "A measurement is not finite.", str(path))
    write_policy(path.with_suffix(".npz"), policy)
    write_bytes(path, msgspec.json.format(msgspec.json.encode(card), indent=1) + b"\n")


def measured_again(task: Task, count: int) -> tuple[float, float, bool]:
    """Measures an expert again on its first ``count`` measurement seeds.

    Returns:
        Its mean return, that of the card (of the first 100 episodes or all), and whether the two differ by
        more than three standard errors.
    """
    card = experts.card(task)
    seeds = [seed(task, "measure", index) for index in range(count)]
    mean = float(np.mean(episodes(experts.load(task), task, seeds)[0]))
    stated = card.first_hundred if count == QUICK else card.measurement.mean
    return mean, stated, abs(mean - stated) > 3 * card.measurement.deviation / count**0.5


def check(tasks: Iterable[Task], count: int) -> Iterator[str]:
    """Measures experts again; a line ends with ``DIFFERS`` if it differs from its card as above."""
    for task in tasks:
        mean, stated, differs = measured_again(task, count)
        yield f"{task.name}: {mean:.2f}, the card says {stated:.2f}{DIFFERS if differs else ''}"


def write_poses(names: Sequence[str], folder: Path = experts.DATA) -> Iterator[str]:
    """Writes the poses of experts that have none of their present policy, and yields a line for each expert.

    They are in the folder ``poses`` of that of the experts' files: the episode with the median return of the
    first 20 measurement seeds. Raises ``BenchError`` without an expert.
    """
    for name in names:
        row, policy = published_task(name), experts.load(name, folder)
        path, digest = folder / POSES / f"{name}.json", experts.digest(policy)
        known = poses.PolicyPoses.load(path, "bad-poses", "python -m tools.experts poses")
        if known is not None and known.policy == digest:
            yield f"{path}: up to date"
            continue
        timing = pose_recorder.timing_of(row)
        seeds = tuple(seed(row, "measure", index) for index in range(SCREENING))
        group = TaskGroup("expert", (row,))
        outcomes, tracks = pose_recorder.recorded(group, policy, Cell(1, 0, seeds), timing)
        returns = [each.return_ for each in outcomes]
        episode = pose_recorder.shown_episode(returns)
        clip = poses.Clip(
            stage=1,
            episode=episode,
            returns=tuple(round(value, 2) for value in returns),
            **pose_recorder.motion(tracks[episode], outcomes[episode], timing),
        )
        shown = filled(poses.TaskPoses, timing, task=row.id, after=clip, end=None)
        yield str(poses.PolicyPoses(policy=digest, poses=shown).write(path))


def tables() -> Iterator[str]:
    """The lines of the documentation's tables, one per body, and the sums."""
    known = load_references().tasks
    states, steps, measuring = Counter[str](), dict[str, float](), 0.0
    for family in dict.fromkeys(FAMILIES.values()):
        yield f"\n### {family}\n"
        yield "| task | floor | expert | standard error | episodes | steps | CPU minutes | state |"
        yield "|---|---:|---:|---:|---:|---:|---:|---|"
        for task in mujoco_tasks():
            if FAMILIES.get(task.base) != family:
                continue
            if (row := known.get(task.id)) is None:
                yield f"| {task.name} | | | | | | | open: no floor |"
                continue
            if task.bare_name not in experts.names():
                yield f"| {task.name} | {row.floor.mean:,.0f} | | | | | | open: no expert |"
                continue
            card = experts.card(task)
            steps |= {step.name: step.cpu_seconds or 0.0 for step in card.history}
            measuring += card.measurement.cpu_seconds or 0.0
            state = f"provisional: {card.provisional}" if card.provisional else "scored"
            state = "open" if row.expert is None else state
            states[state.partition(":")[0]] += 1
            yield _row(task, card, row.floor.mean, state)
    training = sum(steps.values()) / 60
    yield (
        f"\n{states['scored'] + states['provisional']} tasks are scored, {states['provisional']} of them "
        f"with a provisional expert. By the cards, training took {training:,.0f} CPU minutes (without that "
        f"of submissions) and the measurements {measuring / 60:,.0f}.\n"
    )


def _row(task: Task, card: ExpertCard, floor: float, state: str) -> str:
    measured = card.measurement
    digits = 1 if abs(measured.mean) < 1000 else 0
    floor = 0.0 if round(floor, digits) == 0 else floor  # no minus before a zero
    steps = sum(step.steps or 0 for step in card.history) / 1e6
    seconds = sum(step.cpu_seconds or 0.0 for step in card.history)
    state += "; from a submission" if card.from_submission else ""
    return (
        f"| {task.name} | {floor:,.{digits}f} | {measured.mean:,.{digits}f} | "
        f"{measured.standard_error:,.{digits}f} | {measured.episodes} | {steps:.1f}M | "
        f"{seconds / 60:.1f} | {state} |"
    )

"""Checks of published experts: shapes, returns measured again, and policies that challenge them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from gym_extensions import experts
from gym_extensions.baselines.experts.measuring import QUICK, Workplace, episodes, sizes
from gym_extensions.catalog.tasks import Task
from gym_extensions.catalog.tasks import task as published_task
from gym_extensions.experts import seed
from gym_extensions.experts.references import CURRENT, REFERENCES, parse_file
from gym_extensions.rollouts.policies.mlp import Policy

DIFFERS = " (differs)"
THRESHOLD = 1.05
"""Normalized return of a cell's log from which it is evaluated."""
CLEAR_ERRORS = 3.0
"""Standard errors of the difference by which a policy must beat an expert."""


def shape_problem(policy: Policy, task: Task) -> str:
    """What of a policy's shapes is not that of the task, in words; empty if all are."""
    observations, actions = sizes(task)
    if policy.num_inputs != observations:
        return f"has {policy.num_inputs} inputs, and the task {observations} observations"
    if len(policy.action_offset) != actions:
        return f"has {len(policy.action_offset)} actions, and the task {actions}"
    return ""


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


def challenge(
    work: Workplace,
    cells: Mapping[str, Sequence[tuple[float, str]]],
    count: int,
    references: Path = REFERENCES / f"{CURRENT}.json",
) -> Iterator[str]:
    """Evaluates cells of entries above the expert on fresh seeds; yields a line for each.

    A cell is a task after a stage of a run. It is above if the normalized mean of its 20 episodes is above
    ``THRESHOLD``; 20 episodes are noise, so that an equal policy exceeds it now and then. It beats the
    expert if its mean over the fresh episodes is higher by three standard errors of the difference. Open
    tasks and provisional experts are left out.

    Args:
        work: keeps the returns.
        cells: mean return in the log and candidate, the best first, by task (:func:`stored_candidates`).
        count: number of fresh episodes.
        references: the references file.
    """
    known = parse_file(references.read_bytes()).tasks
    for name, ranked in cells.items():
        task = published_task(name)
        row = known[task.id]
        if row.expert is None or not row.expert.policy or row.expert.provisional:
            continue
        floor, expert = row.floor.mean, row.expert
        for mean, candidate in ranked:
            score = (mean - floor) / (expert.mean - floor)
            if score <= THRESHOLD:
                break  # the best are first
            seen = work.evaluate(candidate, task, "challenge", count)
            error = math.hypot(seen.standard_error, expert.standard_error)
            beats = seen.mean - expert.mean > CLEAR_ERRORS * error
            yield (
                f"{task.name} {candidate}: {score:.3f} in its log; in {seen.episodes} episodes "
                f"{seen.mean:.1f} ± {seen.standard_error:.1f}, the expert {expert.mean:.1f} ± "
                f"{expert.standard_error:.1f}{': beats the expert' if beats else ''}"
            )

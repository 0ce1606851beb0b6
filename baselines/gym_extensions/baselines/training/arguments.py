"""The arguments of a training command, checked before anything runs."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from numbers import Integral
from pathlib import Path
from typing import Any

from gym_extensions.baselines.training.jobs import Interim
from gym_extensions.catalog.groups import TaskGroup, groups_named, with_custom
from gym_extensions.catalog.protocol import (
    CURVE_POINTS,
    EVALUATION_EPISODES,
    PROTOCOLS,
    Budget,
    budget as budget_named,
)
from gym_extensions.catalog.tasks import whole_number
from gym_extensions.envs import make_vec
from gym_extensions.errors import BenchError, require_known
from gym_extensions.submissions.layout import MAX_RUNS

Groups = str | Path | TaskGroup | Iterable[str | Path | TaskGroup]


@dataclass(frozen=True)
class Request:
    """Groups, protocols, a budget and runs, without duplicates; environments, if not the budget's."""

    groups: tuple[TaskGroup, ...]
    protocols: tuple[str, ...]
    budget: Budget
    runs: tuple[int, ...]
    num_envs: int | None

    def logs(self) -> list[tuple[TaskGroup, str]]:
        """The group and protocol of every log."""
        return [(group, protocol) for group in self.groups for protocol in self.protocols]


def parse_request(
    groups: Groups,
    protocols: str | Iterable[str],
    budget: str,
    runs: int | Iterable[int],
    num_envs: int | None,
) -> Request:
    """Checks the arguments of :func:`gym_extensions.baselines.train`.

    Raises ``BenchError`` for an unknown name, an empty list, or a number that is not allowed.
    """
    unique_groups = tuple(dict.fromkeys(parse_groups(groups)))
    unique_protocols = tuple(dict.fromkeys(listed(protocols, str, "protocols", "a name")))
    for protocol in unique_protocols:
        require_known("protocol", protocol, PROTOCOLS)
    chosen = budget_named(str(budget))
    unique_runs = tuple(sorted({int(run) for run in listed(runs, Integral, "runs", "an integer")}))
    for run in unique_runs:
        if not 0 <= run < MAX_RUNS:
            raise BenchError("bad-run", f"Run {run} is out of range.", "--runs", f"Use 0 to {MAX_RUNS - 1}.")
    if num_envs is not None:
        num_envs = whole_number("num_envs", num_envs, "bad-num-envs", "--num-envs")
        for group in unique_groups:
            episode_steps, points = max(task.max_steps for task in group.tasks), CURVE_POINTS
            least = episode_steps * points if chosen.on_boards else 1
            limit = chosen.steps_for(group.name) // least
            if num_envs > limit:
                per = f"fewer than {points} episodes" if chosen.on_boards else "less than a step"
                has = f"the budget {chosen.name!r} has {per} per environment"
                hint = f"Use at most {limit} for {group.name}."
                raise BenchError("bad-num-envs", f"With {num_envs} environments, {has}.", "--num-envs", hint)
    return Request(unique_groups, unique_protocols, chosen, unique_runs, num_envs)


def parse_interim(every: int | None, episodes: int) -> Interim | None:
    """The evaluation during training; None if ``every`` is None.

    Raises ``BenchError`` for a number that is not an integer or out of range.
    """
    if every is not None:
        every = whole_number("evaluate_every", every, "bad-evaluate-every", "--evaluate-every")
    option = "--evaluate-episodes"
    episodes = whole_number("evaluate_episodes", episodes, "bad-evaluate-episodes", option)
    if episodes > EVALUATION_EPISODES:
        message = f"{episodes} is too large."
        hint = f"Use at most {EVALUATION_EPISODES}, the episodes that have a prescribed seed."
        raise BenchError("bad-evaluate-episodes", message, option, hint)
    return None if every is None else Interim(every, episodes)


def parse_groups(groups: Groups) -> list[TaskGroup]:
    """The groups of an argument: names of published groups, ``core``, TOML files, TaskGroup objects.

    Raises ``BenchError`` for an unknown name, an invalid file, or two different groups with one name.
    """
    values = listed(groups, (str, Path, TaskGroup), "groups", "a name, a TOML file, a TaskGroup")
    resolved = [group for value in values for group in groups_named(value)]
    with_custom(resolved)
    return resolved


def require_equal_spaces(groups: Iterable[TaskGroup]) -> None:
    """Raises ``BenchError`` if the tasks of a group cannot be created, or have different spaces."""
    for group in groups:
        try:
            make_vec(list(group.tasks), len(group.tasks)).close()
        except BenchError as error:
            raise BenchError(error.code, error.message, group.name, error.hint) from error


def parse_names(text: str) -> list[str]:
    """The names of a comma-separated list."""
    return [name.strip() for name in text.split(",")]


def parse_runs(text: str) -> list[int]:
    """The numbers of a list with ranges such as ``0,2,5-7``; raises ``BenchError`` for anything else."""
    runs: list[int] = []
    for part in text.split(","):
        match = re.fullmatch(r"\s*(\d+)\s*(?:-\s*(\d+)\s*)?", part)
        if match is None:
            hint = "Use numbers and ranges, such as 0,1 or 0-4."
            raise BenchError("bad-runs", f"{text!r} is not a list of runs.", "--runs", hint)
        first, last = int(match[1]), int(match[2] or match[1])
        if last < first:
            hint = f"Write the smaller number first: {last}-{first}."
            raise BenchError("bad-runs", f"The range {part.strip()!r} is empty.", "--runs", hint)
        runs += range(first, last + 1)
    return runs


def listed(value: object, kind: Any, name: str, expected: str) -> list[Any]:
    """A value of a kind as a list, or several of them."""
    items = list(value) if isinstance(value, Iterable) and not isinstance(value, kind) else [value]
    if not items or not all(isinstance(item, kind) for item in items):
        raise BenchError(f"bad-{name}", f"Expected {expected} or several, got {value!r}.", name)
    return items

"""Rules about the logs of a group and protocol: their episodes, what was measured, and identical runs.

Most rules are a mask over the rows of all runs: ``ROW_RULES`` has their masks, texts and messages.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.bodies import UNBOUNDED, Arrival
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, evaluation_seed, stages
from gym_extensions.errors import did_you_mean
from gym_extensions.rollouts.layout import LOG, run_file
from gym_extensions.rollouts.log import FLAGS, Integers, Log
from gym_extensions.rollouts.problem import MAX_QUOTE, Finding, add_rule, rule
from gym_extensions.rollouts.submission import first_identical_runs

Mask = NDArray[np.bool_]
ROWS_LISTED = CELLS_LISTED = 3
"""Rows listed per rule, group and protocol, and incomplete cells per run; the rest are counted."""
PARTNER = {"sequential": "single", "single": "sequential"}
"""The log that has the other run of a pair."""


@dataclass(frozen=True)
class GroupLogs:
    """The readable logs of a group by protocol, and whether the agent has parameters to train."""

    logs: dict[str, Log]
    is_trainable: bool


class LogRows:
    """A log, and what the rules compare its rows with: a value per row.

    Attributes:
        known: whether the task belongs to the group.
        limit: the task's time limit, 0 for a task of another group.
        expected_seed: the prescribed seed, -1 where none is prescribed.
        order: how far the row is behind the row above, in run, stage, task in training order and episode.
        low, high: the lowest and highest return of an episode of this length and end.
        can_end: whether the task can terminate.
        defines_success: whether the task defines success.
        arrives: whether success is the arrival at a goal, which ends the episode.
    """

    def __init__(self, log: Log) -> None:
        self.log, group, position = log, log.group, log.position
        bodies = [task.body for task in group.tasks]

        def by_task(values: Iterable[Any], other: Any) -> NDArray[Any]:
            return np.array([*values, other])[position]

        self.known = position >= 0
        self.limit = by_task((task.max_steps for task in group.tasks), 0)
        seeds = np.full((len(bodies) + 1, EVALUATION_EPISODES + 1), -1)
        for index, task in enumerate(group.task_ids):
            for episode in range(EVALUATION_EPISODES):
                seeds[index, episode] = evaluation_seed(group.id, task, episode)
        is_episode = (log.episode >= 0) & (log.episode < EVALUATION_EPISODES)
        self.expected_seed = seeds[position, np.where(is_episode, log.episode, EVALUATION_EPISODES)]
        code: Integers = log.run
        for column in (log.stage, position, log.episode):
            code = code * 10_000 + np.clip(column, -1, 9_998) + 1
        self.order = np.diff(code, prepend=-1)
        low, high, end = (
            by_task((getattr(body.rewards, name) for body in bodies), getattr(UNBOUNDED, name))
            for name in ("low", "high", "end")
        )
        steps = np.maximum(log.length, 1)
        self.low, self.high = low * steps, high * steps + np.where(log.terminated, end, 0.0)
        self.can_end = by_task((body.rewards.terminates for body in bodies), True)
        self.defines_success = by_task((body.success is not None for body in bodies), False)
        self.arrives = by_task((isinstance(body.success, Arrival) for body in bodies), False)

    def where(self, index: int) -> str:
        """The file of a row, and its line there; the header is line 1."""
        log, first = self.log, int(np.argmax(self.log.run == self.log.run[index]))
        path = run_file(log.group.name, log.protocol, int(log.run[index]), LOG)
        return f"{path}, line {index - first + 2}"

    def row(self, index: int) -> dict[str, object]:
        """What the message about a row may name."""
        log, names = self.log, {value: cell for cell, value in FLAGS.items()}
        last = stages(log.protocol, len(log.group.tasks))[-1]
        return {
            **{name: getattr(log, name)[index] for name in ("stage", "episode", "seed", "length")},
            "stages": f"0 to {last}" if log.protocol == "sequential" else "1",
            "task": log.task[index][:MAX_QUOTE],
            "group": log.group.id,
            "last_episode": EVALUATION_EPISODES - 1,
            "expected_seed": self.expected_seed[index],
            "limit": self.limit[index],
            "return": float(log.return_[index]),
            "lower": float(self.low[index]),
            "upper": float(self.high[index]),
            "terminated": names[bool(log.terminated[index])],
            "success": names[bool(log.success[index])],
        }


@dataclass(frozen=True)
class RowRule:
    """A rule about single rows: its text, the mask of rows that break it, the message, what to do."""

    text: str
    mask: Callable[[LogRows, Log], Mask]
    message: str
    hint: str

    def check(self, rows: LogRows) -> Iterator[Finding]:
        """A finding for each of the first rows that break the rule, then one that counts the rest."""
        log, indices = rows.log, np.flatnonzero(self.mask(rows, rows.log)).tolist()
        for index in indices[:ROWS_LISTED]:
            closest = did_you_mean(log.task[index][:MAX_QUOTE], log.group.task_ids)
            yield Finding(rows.where(index), self.message.format_map(rows.row(index)), self.hint or closest)
        if more := len(indices[ROWS_LISTED:]):
            subject = "1 more row breaks" if more == 1 else f"{more} more rows break"
            yield Finding(log.path, f"{subject} the same rule.", self.hint)


ROW_RULES = {
    "foreign-task": RowRule(
        "Every task of a log belongs to the group of its folder.",
        lambda rows, log: ~rows.known,
        "{task} is not a task of {group}.",
        "",
    ),
    "wrong-stage": RowRule(
        "Stages are 0 to the number of tasks in the sequential protocol, and 1 in the others.",
        lambda rows, log: ~np.isin(log.stage, stages(log.protocol, len(log.group.tasks))),
        "Column `stage` is {stage}; expected {stages}.",
        "The stage is the number of tasks trained so far; it is 1 (trained) where a protocol has one stage.",
    ),
    "wrong-episode": RowRule(
        f"Episodes of a cell are numbered 0 to {EVALUATION_EPISODES - 1}.",
        lambda rows, log: (log.episode < 0) | (log.episode >= EVALUATION_EPISODES),
        "Column `episode` is {episode}; expected 0 to {last_episode}.",
        f"Evaluate {EVALUATION_EPISODES} episodes per cell, numbered from 0.",
    ),
    "wrong-seed": RowRule(
        "Every episode starts from the seed prescribed for its group, task and number.",
        lambda rows, log: (rows.expected_seed >= 0) & (log.seed != rows.expected_seed),
        "Column `seed` is {seed}; expected {expected_seed} for this episode.",
        "Reset with gym_extensions.catalog.protocol.evaluation_seed(group id, task id, episode).",
    ),
    "unsorted-rows": RowRule(
        "Rows are sorted by stage, task in training order and episode, and no episode is repeated.",
        lambda rows, log: rows.order <= 0,
        "Stage {stage}, {task}, episode {episode} does not follow the row above.",
        "Sort by stage, task in training order and episode; write each episode once.",
    ),
    "not-finite": RowRule(
        "Every return is a finite number.",
        lambda rows, log: ~np.isfinite(log.return_),
        "Column `return` is {return}; expected a finite number.",
        "Find the cause in the policy or in the sum of rewards; such an episode cannot be scored.",
    ),
    "impossible-length": RowRule(
        "The length of an episode is 1 to the task's time limit.",
        lambda rows, log: rows.known & ((log.length < 1) | (log.length > rows.limit)),
        "Column `length` is {length}; expected 1 to {limit} steps.",
        "Count the steps from the reset to the end of the episode.",
    ),
    "unfinished-episode": RowRule(
        "An episode that the task does not terminate runs to the time limit.",
        lambda rows, log: ~log.terminated & (log.length >= 1) & (log.length < rows.limit),
        "The episode ends after {length} of {limit} steps, but `terminated` is false.",
        "Evaluate every episode to its end; write true in `terminated` if the task ended it.",
    ),
    "impossible-end": RowRule(
        "`terminated` is true only in tasks that can terminate; reaching the time limit is not termination.",
        lambda rows, log: log.terminated & ~rows.can_end,
        "Column `terminated` is true, but {task} never terminates.",
        "Write false in `terminated` if the time limit ended the episode.",
    ),
    "impossible-return": RowRule(
        "A return is within the bounds of the task's rewards over the episode's steps (catalog/bodies).",
        lambda rows, log: (
            np.isfinite(log.return_)
            & (log.length >= 1)
            & ((log.return_ < rows.low) | (log.return_ > rows.high))
        ),
        "Column `return` is {return!r}; expected {lower:g} to {upper:g} in {length} steps of this task.",
        "Write the undiscounted, unscaled sum of the rewards.",
    ),
    "missing-success": RowRule(
        "`success` is true or false in tasks that define success.",
        lambda rows, log: (log.success < 0) & rows.defines_success,
        "Column `success` is empty, but {task} defines success.",
        'Write info["is_success"] of the last step of the episode.',
    ),
    "undefined-success": RowRule(
        "`success` is empty in tasks that define no success, such as the running tasks.",
        lambda rows, log: rows.known & (log.success >= 0) & ~rows.defines_success,
        "Column `success` is {success}, but {task} defines no success.",
        "Leave the cell empty.",
    ),
    "contradictory-success": RowRule(
        "Where success is the arrival at a goal, `success` equals `terminated`.",
        lambda rows, log: rows.arrives & (log.success >= 0) & (log.success != log.terminated),
        "Column `success` is {success}, but `terminated` is {terminated}.",
        "This task ends at the goal, and only there: write the same value in both columns.",
    ),
}
"""The rules about rows by name."""
for _name, _rule in ROW_RULES.items():
    add_rule(_name, "log", _rule.text, _rule.check)


@rule("log")
def missing_cell(rows: LogRows) -> Iterator[Finding]:
    """Every run has all its cells (stage and task), each with 20 episodes."""
    log = rows.log
    names, all_stages = log.group.task_ids, stages(log.protocol, len(log.group.tasks))
    is_prescribed = rows.known & np.isin(log.stage, all_stages)
    is_prescribed &= (log.episode >= 0) & (log.episode < EVALUATION_EPISODES)
    cells = (log.run * 10_000 + log.stage) * 10_000 + log.position
    episodes = np.unique(cells[is_prescribed] * EVALUATION_EPISODES + log.episode[is_prescribed])
    codes, counts = np.unique(episodes // EVALUATION_EPISODES, return_counts=True)
    found = dict(zip(codes.tolist(), counts.tolist(), strict=True))
    hint = "Finish the evaluation of this run, or leave out the whole run."
    for run in log.runs:
        where = run_file(log.group.name, log.protocol, run, LOG)
        counted = {
            (stage, name): found.get((run * 10_000 + stage) * 10_000 + position, 0)
            for stage in all_stages
            for position, name in enumerate(names)
        }
        incomplete = [cell for cell, count in counted.items() if count < EVALUATION_EPISODES]
        for cell in incomplete[:CELLS_LISTED]:
            message = f"Stage {cell[0]}, {cell[1]} has {counted[cell]} of {EVALUATION_EPISODES} episodes."
            yield Finding(where, message, hint)
        if more := len(incomplete[CELLS_LISTED:]):
            message = f"{more} more cell{'s' if more > 1 else ''} of the run lack episodes."
            yield Finding(where, message, hint)


@rule("group")
def identical_runs(group: GroupLogs) -> Iterator[Finding]:
    """No two runs of a trainable agent are identical in every episode. (Runs of an agent without parameters
    may be, in both the sequential and the single protocol: they count as one, and the scorecard says so.)"""
    first = {protocol: first_identical_runs(log) for protocol, log in group.logs.items()}
    for protocol, log in group.logs.items():
        partner = first.get(PARTNER.get(protocol, ""), {})
        for run, original in first[protocol].items():
            is_identical_pair = partner.get(run, partner.get(original)) == partner.get(original)
            if run == original or (is_identical_pair and not group.is_trainable):
                continue
            message = f"Run {run} is identical to run {original} in every episode."
            hint = "Train each run with its own seed; for an agent without parameters, say so in memory."
            if not (is_identical_pair or group.is_trainable):
                message += f" In the protocol {PARTNER[protocol]} they differ."
                hint = "Train each run with its own seed, and write both logs from the same agent."
            yield Finding(run_file(log.group.name, protocol, run, LOG), message, hint)

"""Rules about the logs of a group and protocol: their episodes, what was measured, and identical runs.

Most rules are a mask over the rows of all runs: ``ROW_RULES`` has their masks, texts and messages.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.bodies import UNBOUNDED, Arrival
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, IN_ORDER, evaluation_seed, stages
from gym_extensions.errors import did_you_mean
from gym_extensions.submissions import layout
from gym_extensions.submissions.log import Log
from gym_extensions.submissions.problem import MAX_QUOTE, RULES, Finding, Rule, count, rule

if TYPE_CHECKING:
    import pandas as pd

ROWS_LISTED = CELLS_LISTED = 3
"""Rows listed per rule, group and protocol, and incomplete cells per run; the rest are counted."""


def compared_rows(log: Log) -> pd.DataFrame:
    """The rows of a log, with columns of what the rules compare them with.

    * ``known``: whether the task belongs to the group
    * ``limit``: the task's time limit, 0 for a task of another group
    * ``expected_seed``: the prescribed seed, -1 where none is prescribed
    * ``order``: how far the row is behind the row above, in run, stage, task (as in the group) and episode
    * ``low``, ``high``: the lowest and highest return of an episode of this length and end
    * ``can_end``, ``defines_success``: whether the task can terminate, and whether it defines success
    * ``arrives``: whether success is the arrival at a goal, which ends the episode
    """
    names = ("run", "stage", "position", "episode", "length", "terminated")
    run, stage, position, episode, length, terminated = (log.rows[name].to_numpy() for name in names)
    tasks = log.group.tasks
    # The last element is for the position -1, of a task of another group.
    limits = [*(task.max_steps for task in tasks), 0]
    rewards = [*(task.body.rewards for task in tasks), UNBOUNDED]
    successes = [*(task.body.success for task in tasks), None]

    def by_task(values: Sequence[Any]) -> Any:
        return np.array(values)[position]

    seeds = np.full((len(tasks) + 1, EVALUATION_EPISODES + 1), -1)
    for index, task in enumerate(log.group.task_ids):
        for number in range(EVALUATION_EPISODES):
            seeds[index, number] = evaluation_seed(log.group.id, task, number)
    is_episode = (episode >= 0) & (episode < EVALUATION_EPISODES)
    code = run
    for column in (stage, position, episode):
        code = code * 10_000 + np.clip(column, -1, 9_998) + 1
    steps, ends = np.maximum(length, 1), by_task([each.end for each in rewards])
    return log.rows.assign(
        known=position >= 0,
        limit=by_task(limits),
        expected_seed=seeds[position, np.where(is_episode, episode, EVALUATION_EPISODES)],
        order=np.diff(code, prepend=-1),
        low=by_task([each.low for each in rewards]) * steps,
        high=by_task([each.high for each in rewards]) * steps + np.where(terminated, ends, 0.0),
        can_end=by_task([each.terminates for each in rewards]),
        defines_success=by_task([each is not None for each in successes]),
        arrives=by_task([isinstance(each, Arrival) for each in successes]),
    )


def where(log: Log, index: int) -> str:
    """The file of a row, and its line there; the header is line 1."""
    runs = log.rows["run"]
    run = int(runs[index])
    path = layout.run_file(log.group.name, log.protocol, run, layout.LOG)
    return f"{path}, line {index - int(np.argmax(runs == run)) + 2}"


class RowRule(NamedTuple):
    """A rule about single rows: its text, the mask of rows that break it, the message, what to do."""

    text: str
    mask: Callable[[pd.DataFrame, Log], Any]
    message: str
    hint: str

    def check(self, rows: pd.DataFrame, log: Log) -> Iterator[Finding]:
        """A finding for each of the first rows that break the rule, then one that counts the rest."""
        indices = np.flatnonzero(self.mask(rows, log)).tolist()
        last = stages(log.protocol, len(log.group.tasks))[-1]
        for index in indices[:ROWS_LISTED]:
            row: dict[Any, Any] = rows.iloc[[index]].to_dict("records")[0]
            stated = row | {
                "stages": f"0 to {last}" if log.protocol in IN_ORDER else "1",
                "task": row["task"][:MAX_QUOTE],
                "group": log.group.id,
                "last_episode": EVALUATION_EPISODES - 1,
                "terminated": str(row["terminated"]).lower(),
                "success": str(bool(row["success"])).lower(),
            }
            closest = did_you_mean(str(stated["task"]), log.group.task_ids)
            yield Finding(where(log, index), self.message.format_map(stated), self.hint or closest)
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
        "Stages are 0 to the number of tasks where tasks are learned one after another, and 1 in the others.",
        lambda rows, log: ~np.isin(rows.stage, stages(log.protocol, len(log.group.tasks))),
        "Column `stage` is {stage}; expected {stages}.",
        "The stage is the number of tasks trained so far; it is 1 (trained) where a protocol has one stage.",
    ),
    "wrong-episode": RowRule(
        f"Episodes of a cell are numbered 0 to {EVALUATION_EPISODES - 1}.",
        lambda rows, log: (rows.episode < 0) | (rows.episode >= EVALUATION_EPISODES),
        "Column `episode` is {episode}; expected 0 to {last_episode}.",
        f"Evaluate {EVALUATION_EPISODES} episodes per cell, numbered from 0.",
    ),
    "wrong-seed": RowRule(
        "Every episode starts from the seed prescribed for its group, task and number.",
        lambda rows, log: (rows.expected_seed >= 0) & (rows.seed != rows.expected_seed),
        "Column `seed` is {seed}; expected {expected_seed} for this episode.",
        "Reset with gym_extensions.catalog.protocol.evaluation_seed(group id, task id, episode).",
    ),
    "unsorted-rows": RowRule(
        "Rows are sorted by stage, task in the order of the group and episode; no episode is repeated.",
        lambda rows, log: rows.order <= 0,
        "Stage {stage}, {task}, episode {episode} does not follow the row above.",
        "Sort by stage, task in the order of the group and episode; write each episode once.",
    ),
    "not-finite": RowRule(
        "Every return is a finite number.",
        lambda rows, log: ~np.isfinite(rows["return"]),
        "Column `return` is {return}; expected a finite number.",
        "Find the cause in the policy or in the sum of rewards; such an episode cannot be scored.",
    ),
    "impossible-length": RowRule(
        "The length of an episode is 1 to the task's time limit.",
        lambda rows, log: rows.known & ((rows.length < 1) | (rows.length > rows.limit)),
        "Column `length` is {length}; expected 1 to {limit} steps.",
        "Count the steps from the reset to the end of the episode.",
    ),
    "unfinished-episode": RowRule(
        "An episode that the task does not terminate runs to the time limit.",
        lambda rows, log: ~rows.terminated & (rows.length >= 1) & (rows.length < rows.limit),
        "The episode ends after {length} of {limit} steps, but `terminated` is false.",
        "Evaluate every episode to its end; write true in `terminated` if the task ended it.",
    ),
    "impossible-end": RowRule(
        "`terminated` is true only in tasks that can terminate; reaching the time limit is not termination.",
        lambda rows, log: rows.terminated & ~rows.can_end,
        "Column `terminated` is true, but {task} never terminates.",
        "Write false in `terminated` if the time limit ended the episode.",
    ),
    "impossible-return": RowRule(
        "A return is within the bounds of the task's rewards over the episode's steps (catalog/bodies).",
        lambda rows, log: (
            np.isfinite(rows["return"])
            & (rows.length >= 1)
            & ((rows["return"] < rows.low) | (rows["return"] > rows.high))
        ),
        "Column `return` is {return!r}; expected {low:g} to {high:g} in {length} steps of this task.",
        "Write the undiscounted, unscaled sum of the rewards.",
    ),
    "missing-success": RowRule(
        "`success` is true or false in tasks that define success.",
        lambda rows, log: (rows.success < 0) & rows.defines_success,
        "Column `success` is empty, but {task} defines success.",
        'Write info["is_success"] of the last step of the episode.',
    ),
    "undefined-success": RowRule(
        "`success` is empty in tasks that define no success, such as the running tasks.",
        lambda rows, log: rows.known & (rows.success >= 0) & ~rows.defines_success,
        "Column `success` is {success}, but {task} defines no success.",
        "Leave the cell empty.",
    ),
    "contradictory-success": RowRule(
        "Where success is the arrival at a goal, `success` equals `terminated`.",
        lambda rows, log: rows.arrives & (rows.success >= 0) & (rows.success != rows.terminated),
        "Column `success` is {success}, but `terminated` is {terminated}.",
        "This task ends at the goal, and only there: write the same value in both columns.",
    ),
}
"""The rules about rows by name."""
for _name, _rule in ROW_RULES.items():
    RULES[_name] = Rule(_name, "log", _rule.text, _rule.check)


@rule("log")
def missing_cell(rows: pd.DataFrame, log: Log) -> Iterator[Finding]:
    """Every run has all its cells (stage and task), each with 20 episodes."""
    names, all_stages = log.group.task_ids, stages(log.protocol, len(log.group.tasks))
    prescribed = rows[rows.episode.between(0, EVALUATION_EPISODES - 1)]
    cells = prescribed.groupby(["run", "stage", "position"])["episode"].nunique().to_dict()
    hint = "Finish the evaluation of this run, or leave out the whole run."
    for run in log.runs:
        where = layout.run_file(log.group.name, log.protocol, run, layout.LOG)
        counted = {
            (stage, name): cells.get((run, stage, position), 0)
            for stage in all_stages
            for position, name in enumerate(names)
        }
        incomplete = [cell for cell, episodes in counted.items() if episodes < EVALUATION_EPISODES]
        for cell in incomplete[:CELLS_LISTED]:
            message = f"Stage {cell[0]}, {cell[1]} has {counted[cell]} of {EVALUATION_EPISODES} episodes."
            yield Finding(where, message, hint)
        if more := len(incomplete[CELLS_LISTED:]):
            yield Finding(where, f"{count(more, 'more cell')} of the run lack episodes.", hint)


TOLERANCE = 1e-5
"""Largest difference of identical returns, absolute and relative: a copy with noise is the same run."""


def first_identical_runs(log: Log) -> Mapping[int, int]:
    """For each run, the first run that is identical in every episode.

    That is the run itself if it is the first. Returns that differ by less than ``TOLERANCE`` are identical.
    """
    ordered = log.rows.sort_values(["run", "stage", "position", "episode"], kind="stable")
    names = ["stage", "position", "episode", "length", "terminated", "success"]
    firsts: dict[bytes, list[tuple[int, NDArray[np.float64]]]] = {}
    result = {}
    for run in log.runs:
        rows = ordered[ordered["run"] == run]
        candidates = firsts.setdefault(b"".join(rows[name].to_numpy().tobytes() for name in names), [])
        returns = rows["return"].to_numpy()
        equal = (each for each, other in candidates if np.allclose(returns, other, TOLERANCE, TOLERANCE))
        result[run] = next(equal, run)
        if result[run] == run:
            candidates.append((run, returns))
    return result


@rule("log")
def identical_runs(rows: pd.DataFrame, log: Log) -> Iterator[Finding]:
    """No two runs are identical in every episode. (An agent that always does the same has one run.)"""
    for run, original in first_identical_runs(log).items():
        if run != original:
            where = layout.run_file(log.group.name, log.protocol, run, layout.LOG)
            message = f"Run {run} is identical to run {original} in every episode."
            yield Finding(where, message, "Train each run with its own seed, or leave the run out.")

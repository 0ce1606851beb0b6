"""Scores of submissions as data frames: the metrics of each, and the boards that compare them."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

import pandas as pd

from gym_extensions.catalog.budgets import BUDGETS, STANDARD_BUDGET
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.catalog.suites import SUITES
from gym_extensions.errors import BenchError, did_you_mean
from gym_extensions.results.columns import check_columns, select_columns
from gym_extensions.results.submissions import CustomGroups, Paths, find, refuse_problems
from gym_extensions.scoring.leaderboard.board import board as board_of
from gym_extensions.scoring.leaderboard.keys import BoardKey
from gym_extensions.scoring.output.frames import METRIC_DTYPES, board_dtypes, board_frame, metrics_frame
from gym_extensions.scoring.pipeline.score import Scorer, make_scorer, scorecard_document
from gym_extensions.scoring.scorecard.model import Scorecard, ScorecardDocument


def metrics(
    submissions: Paths,
    columns: Sequence[str] | None = None,
    *,
    groups: CustomGroups = (),
    references: str | Path | None = None,
) -> pd.DataFrame:
    """Every metric of the submissions, one row per submission, group or suite, protocol and metric.

    ========  =======  =============================================================================
    column    dtype    value
    ========  =======  =============================================================================
    name      str      name of the submission's folder
    trust     str      ``reported``, ``validated`` or ``replayed (…)``
    group     str      group id, or name of a suite
    protocol  str      ``sequential``, ``single`` or ``joint``
    budget    str      name of the training budget
    runs      Int64    number of runs; missing for a suite, 0 for a reported entry
    metric    str      name of the metric (docs/metrics.md)
    mean      float64  mean over runs, in normalized return: 0 = floor, 1 = reference; may be missing
    low       float64  lower end of the 95 % interval; missing with one run or without a mean
    high      float64  upper end of the 95 % interval; missing with one run or without a mean
    why       str      why the mean or the interval is missing; else empty
    ========  =======  =============================================================================

    Args:
        submissions: a submission, a folder of submissions, or a list of these.
        columns: the columns to return, in this order; all by default.
        groups: custom groups that the submissions may contain: TOML files or TaskGroup objects.
        references: the references file of the custom groups' tasks.

    Raises:
        BenchError: a path does not exist, a submission has problems, or a column is unknown.
    """
    check_columns(columns, METRIC_DTYPES)
    return select_columns(metrics_frame(_document(submissions, make_scorer(groups, references))), columns)


def board(
    group: str | TaskGroup,
    submissions: Paths = "submissions",
    protocol: str = "sequential",
    budget: str = STANDARD_BUDGET,
    *,
    task_conditioned: bool = False,
    columns: Sequence[str] | None = None,
    groups: CustomGroups = (),
    references: str | Path | None = None,
) -> pd.DataFrame:
    """A board: the submissions with results on it, one per row.

    Ranked entries are sorted by the protocol's first metric (final performance, or single-task performance),
    best first; the others follow.

    ================  =======  =====================================================================
    column            dtype    value
    ================  =======  =====================================================================
    rank_first        Int64    best possible rank by the first metric; missing without a rank
    rank_last         Int64    worst possible rank by the first metric; missing without a rank
    name              str      name of the submission's folder
    title             str      title of the submission
    trust             str      ``reported``, ``validated`` or ``replayed (…)``
    evaluation        str      ``sampled`` or ``deterministic``: how actions are selected in evaluation
    runs              int64    number of runs; on a suite the fewest of its groups
    ranked            bool     whether the board ranks the entry
    why               str      why the entry is not ranked; else empty
    ``METRIC``        float64  mean over runs, in normalized return: 0 = floor, 1 = reference; may be missing
    ``METRIC_low``    float64  lower end of its 95 % interval; missing with one run or without a mean
    ``METRIC_high``   float64  upper end of its 95 % interval; missing with one run or without a mean
    ================  =======  =====================================================================

    The last three columns are repeated for every metric of the protocol, in the order of docs/metrics.md:
    ``final_performance``, ``final_performance_low``, ``final_performance_high`` and so on.

    Args:
        group: name or id of a group (``hopper-gravity``, ``hopper-gravity-v0``), name of a suite, or a
            TaskGroup.
        submissions: a submission, a folder of submissions, or a list of these.
        protocol: ``sequential``, ``single`` or ``joint``.
        budget: name of the training budget. The site has no board of the budget ``smoke``.
        task_conditioned: whether the agents observe the task in evaluation.
        columns: the columns to return, in this order; all by default.
        groups: custom groups that the submissions may contain: TOML files or TaskGroup objects.
        references: the references file of the custom groups' tasks.

    Raises:
        BenchError: a group, protocol, budget, path or column is unknown, or a submission has problems.

    Warns:
        UserWarning: the board is empty, and the submissions have results with another budget.
    """
    if isinstance(group, TaskGroup):
        groups, group = (*groups, group), group.name
    scorer = make_scorer(groups, references)
    group_id = _group_id(group, scorer.groups)
    _check("protocol", protocol, PROTOCOLS)
    _check("budget", budget, BUDGETS)
    check_columns(columns, board_dtypes(protocol))
    cards = _document(submissions, scorer).submissions
    key = BoardKey(group_id, protocol, budget, task_conditioned)
    found = board_of(cards, key)
    if not found.rows:
        _warn_of_another_budget(cards, key)
    return select_columns(board_frame(found), columns)


def _warn_of_another_budget(cards: Sequence[Scorecard], key: BoardKey) -> None:
    """Warns if the submissions have results on the board's group and protocol, but with another budget."""
    scores = [card.groups.get(key.group, {}).get(key.protocol) for card in cards]
    budgets = sorted({score.budget for score in scores if score})
    if budgets and key.budget not in budgets:
        board_name = f"{key.group}, {key.protocol}, budget {key.budget}"
        message = f"The board of {board_name} is empty. The submissions have the budget {', '.join(budgets)}."
        warnings.warn(message, UserWarning, stacklevel=3)


def _group_id(name: str, groups: Mapping[str, TaskGroup]) -> str:
    """The name of a suite, or the id of a group."""
    ids = {group.id: group.id for group in groups.values()} | {
        short: group.id for short, group in groups.items()
    }
    if name not in SUITES and name not in ids:
        hint = did_you_mean(str(name), [*groups, *SUITES])
        raise BenchError("unknown-group", f"There is no group or suite {name!r}.", "group", hint)
    return ids.get(name, name)


def _check(argument: str, name: str, choices: Collection[str]) -> None:
    if name not in choices:
        hint = did_you_mean(str(name), choices)
        raise BenchError(f"unknown-{argument}", f"There is no {argument} {name!r}.", argument, hint)


def _document(submissions: Paths, scorer: Scorer) -> ScorecardDocument:
    """The scorecards, made in this process: a notebook on Windows or macOS cannot start workers safely."""
    cards = []
    for folder in find(submissions):
        card = scorer(folder)
        refuse_problems(folder, card.problems)
        cards.append(card)
    return scorecard_document(cards, scorer.references)

"""Scores of submissions as data frames: the metrics of each, and the boards that compare them."""

from __future__ import annotations

import math
import warnings
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy.typing as npt
import pandas as pd

from gym_extensions.catalog.groups import SUITES, TaskGroup
from gym_extensions.catalog.protocol import BUDGETS, PROTOCOLS, STANDARD_BUDGET
from gym_extensions.errors import BenchError, did_you_mean
from gym_extensions.metrics import compute
from gym_extensions.results.frames import (
    CustomGroups,
    Paths,
    check_columns,
    concat,
    find,
    refuse_problems,
    select_columns,
)
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.tables import Log
from gym_extensions.scoring.boards import BoardKey, CoreBoard
from gym_extensions.scoring.frames import (
    CORE_DTYPES,
    METRIC_DTYPES,
    PAIR_DTYPES,
    board_dtypes,
    board_frame,
    core_frame,
    core_pairs_frame,
    metrics_frame,
    typed,
)
from gym_extensions.scoring.leaderboard import board as board_of
from gym_extensions.scoring.leaderboard import core as core_of
from gym_extensions.scoring.pipeline import Scorer, make_scorer, scorecard_document
from gym_extensions.scoring.references import References
from gym_extensions.scoring.scorecard import Scorecard, ScorecardDocument


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
    level     str      ``reported``, ``claimed``, ``verified`` or ``reproduced``
    group     str      group id, or name of a suite
    protocol  str      ``sequential``, ``single``, ``joint`` or ``cumulative``
    budget    str      name of the training budget
    runs      Int64    number of runs; missing for a suite, 0 for a reported entry
    metric    str      name of the metric (docs/metrics.md)
    mean      float64  mean over runs, in normalized return: 0 = floor, 1 = expert; may be missing
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
    best first; the others follow, and at the end ``alone`` (the reference agent on each task alone, with the
    budget ``300k``), ``random`` and ``zero``, computed from the references. Only the groups of the board are
    read.

    ================  =======  =====================================================================
    column            dtype    value
    ================  =======  =====================================================================
    rank_first        Int64    best possible rank by the first metric; missing without a rank
    rank_last         Int64    worst possible rank by the first metric; missing without a rank
    name              str      name of the submission's folder
    title             str      title of the submission
    level             str      ``reported``, ``claimed``, ``verified`` or ``reproduced``
    evaluation        str      ``sampled`` or ``deterministic``: how actions are selected in evaluation
    runs              int64    number of runs; on a suite the fewest of its groups
    ranked            bool     whether the board ranks the entry
    why               str      why the entry is not ranked; else empty
    ``METRIC``        float64  mean over runs, in normalized return: 0 = floor, 1 = expert; may be missing
    ``METRIC_low``    float64  lower end of its 95 % interval; missing with one run or without a mean
    ``METRIC_high``   float64  upper end of its 95 % interval; missing with one run or without a mean
    ================  =======  =====================================================================

    The last three columns are repeated for every metric of the board, in the order of docs/metrics.md:
    ``final_performance``, ``final_performance_low``, ``final_performance_high`` and so on.

    Args:
        group: name or id of a group (``hopper-gravity``, ``hopper-gravity-v0``), name of a suite, or a
            TaskGroup.
        submissions: a submission, a folder of submissions, or a list of these.
        protocol: ``sequential``, ``single``, ``joint`` or ``cumulative``.
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
    names = SUITES.get(group_id, (group_id,))
    only = tuple(name for name, known in scorer.groups.items() if {name, known.id} & set(names))
    cards = _document(submissions, replace(scorer, only=only)).submissions
    key = BoardKey(group_id, protocol, budget, task_conditioned)
    found = board_of(cards, key, scorer.references)
    if not found.rows:
        _warn_of_another_budget(cards, key)
        found = replace(found, computed=())
    return select_columns(board_frame(found), columns)


def core(
    submissions: Paths = "submissions",
    *,
    columns: Sequence[str] | None = None,
    references: str | Path | None = None,
) -> pd.DataFrame:
    """The core board: one row per method, over all groups of the core (docs/metrics.md).

    Ranked methods come first, best first; only the groups of the core are read.

    =====================  =======  ================================================================
    column                 dtype    value
    =====================  =======  ================================================================
    rank_first, rank_last  Int64    best and worst possible rank; missing without a rank
    name, title, level     str      as on boards
    observes_task          bool     whether the agent observes the task in evaluation
    look                   int64    n: runs 0 to n − 1 of every group are compared
    next_look              Int64    the next look; missing after the last
    ranked, why            bool     whether the method is compared; why it is not (str)
    vs_first               str      ``separated``, ``equivalent`` or ``open``: against the first row
    vs_reference           str      the same against ``trpo``
    ``METRIC``             float64  mean over groups; also ``METRIC_low`` and ``METRIC_high``
    ``GROUP``              float64  final performance on each group, by its id; may be missing
    steps, cpu_seconds     float64  what one run of all groups takes; missing where it is not stated
    peak_memory_mb         float64  largest memory of a process
    stored_steps           Int64    most transitions stored at once
    parameters             Int64    parameters at the end of training
    notes                  str      what is not compared, in words
    =====================  =======  ================================================================

    The metrics are ``final_performance``, ``learning_performance`` and ``forgetting``.

    Args:
        submissions: a submission, a folder of submissions, or a list of these.
        columns: the columns to return, in this order; all by default.
        references: a references file, if not that of the current benchmark version.

    Raises:
        BenchError: a path or column is unknown, or a submission has problems.
    """
    check_columns(columns, CORE_DTYPES)
    return select_columns(core_frame(_core_board(submissions, references)), columns)


def core_pairs(
    submissions: Paths = "submissions",
    *,
    columns: Sequence[str] | None = None,
    references: str | Path | None = None,
) -> pd.DataFrame:
    """Every pair of ranked methods on the core board, for final performance and for forgetting.

    The columns are ``metric``, ``first``, ``second``, ``look``, ``paired``, the difference first − second as
    ``mean``, ``low`` and ``high`` (adjusted for all pairs and looks), the adjusted ``p_value``, ``verdict``
    (``separated``, ``equivalent`` or ``open``), ``exploratory`` and ``next_look``. docs/scorecard.md says
    more. The arguments are those of :func:`core`.

    Raises:
        BenchError: a path or column is unknown, or a submission has problems.
    """
    check_columns(columns, PAIR_DTYPES)
    return select_columns(core_pairs_frame(_core_board(submissions, references)), columns)


def _core_board(submissions: Paths, references: str | Path | None) -> CoreBoard | None:
    scorer = make_scorer((), references, ("core",))
    return core_of(_document(submissions, scorer).submissions)


SCORE_DTYPES = {
    "submission": "str",
    "group": "str",
    "protocol": "str",
    "run": "int64",
    "stage": "int64",
    "task": "str",
    "return": "float64",
    "normalized": "float64",
}


def scores(
    submissions: Paths,
    group: str | TaskGroup,
    protocol: str = "sequential",
    *,
    stage: int | None = None,
    columns: Sequence[str] | None = None,
    groups: CustomGroups = (),
    references: str | Path | None = None,
) -> pd.DataFrame:
    """The mean return of every run, stage and task, raw and normalized: what the metrics are made of.

    ==========  =======  ===========================================================================
    column      dtype    value
    ==========  =======  ===========================================================================
    submission  str      name of the submission's folder
    group       str      group id
    protocol    str      ``sequential``, ``single``, ``joint`` or ``cumulative``
    run         int64    training seed
    stage       int64    number of tasks trained so far: 0 untrained; 1 in the other protocols
    task        str      task id, in training order
    return      float64  mean over the 20 episodes
    normalized  float64  the same: 0 = floor, 1 = expert; missing for a task without an expert
    ==========  =======  ===========================================================================

    Args:
        submissions: a submission, a folder of submissions, or a list of these.
        group: name or id of a group, or a TaskGroup.
        protocol: ``sequential``, ``single``, ``joint`` or ``cumulative``.
        stage: of which stage; -1 for the last one, None for all.
        columns: the columns to return, in this order; all by default.
        groups: custom groups that the submissions may contain: TOML files or TaskGroup objects.
        references: the references file of the custom groups' tasks.

    Raises:
        BenchError: a group, protocol, path or column is unknown, or a submission has problems.

    """
    if isinstance(group, TaskGroup):
        groups, group = (*groups, group), group.name
    scorer = make_scorer(groups, references)
    group_id = _group_id(group, scorer.groups)
    _check("protocol", protocol, PROTOCOLS)
    check_columns(columns, SCORE_DTYPES)
    name = next((name for name, known in scorer.groups.items() if known.id == group_id), "")
    frames = []
    for folder in find(submissions):
        submission = read(folder, scorer.groups, only=(name,))
        refuse_problems(folder, submission.problems)
        submitted = submission.groups.get(group_id)
        if submitted is not None and protocol in submitted.logs:
            frame = _means(submitted.logs[protocol], scorer.references)
            frames.append(frame.assign(submission=submission.name, group=group_id, protocol=protocol))
    frame = concat(frames, SCORE_DTYPES)[list(SCORE_DTYPES)]
    if stage is not None:
        frame = frame[frame["stage"] == (frame["stage"].max() if stage == -1 else stage)]
    return select_columns(frame.reset_index(drop=True), columns)


def score_matrix(
    submission: str | Path,
    group: str | TaskGroup,
    protocol: str = "sequential",
    values: str = "normalized",
    *,
    stage: int = -1,
    groups: CustomGroups = (),
    references: str | Path | None = None,
) -> pd.DataFrame:
    """The mean return of every run on every task after one stage, (runs, tasks), which rliable expects.

    The rows are the runs (index ``run``), the columns the tasks in training order (``task``);
    ``to_numpy()`` gives the array.

    Args:
        submission: one submission.
        group: name or id of a group, or a TaskGroup.
        protocol: ``sequential``, ``single``, ``joint`` or ``cumulative``.
        values: ``normalized`` (0 = floor, 1 = expert) or ``return``.
        stage: of which stage; -1 for the last one.
        groups: custom groups that the submission may contain: TOML files or TaskGroup objects.
        references: the references file of the custom groups' tasks.

    Raises:
        BenchError: as in :func:`scores`; or the path contains several submissions, or none with such runs.

    Example:
        >>> score_matrix("submissions/trpo", "hopper-gravity").shape
        (10, 5)
    """
    _check("values", values, ("normalized", "return"))
    frame = scores(submission, group, protocol, stage=stage, groups=groups, references=references)
    if frame["submission"].nunique() != 1:
        message = f"There are {frame['submission'].nunique()} submissions with runs of this group and stage."
        raise BenchError("no-matrix", message, str(submission), "Name one submission.")
    return frame.pivot(index="run", columns="task", values=values)[list(dict.fromkeys(frame["task"]))]


def _means(log: Log, references: References) -> pd.DataFrame:
    """The mean return of every run, stage and task of a log, in its order."""
    rows = pd.DataFrame({"run": log.run, "stage": log.stage, "task": log.task, "return": log.return_})
    cells = rows.groupby(["run", "stage", "task"], sort=False)["return"]
    frame = cells.agg(lambda values: math.fsum(values) / len(values)).reset_index()
    known = {task: reference for task, reference in references.tasks.items() if not reference.open}
    pairs = zip(frame["task"], frame["return"], strict=True)
    normalized = [known[task].normalize(value) if task in known else math.nan for task, value in pairs]
    return frame.assign(normalized=normalized)


def metrics_of(
    matrix: npt.ArrayLike, single: npt.ArrayLike | None = None, columns: Sequence[str] | None = None
) -> pd.DataFrame:
    """The metrics of a matrix of returns from anywhere, as a frame; :func:`gym_extensions.metrics.compute`
    takes more.

    ======  =======  ===============================================================================
    column  dtype    value
    ======  =======  ===============================================================================
    metric  str      name of the metric (docs/metrics.md)
    mean    float64  mean over runs, in the unit of the matrix; missing where it needs more than that
    low     float64  lower end of the 95 % interval; missing with one run or without a mean
    high    float64  upper end of the 95 % interval; missing with one run or without a mean
    ======  =======  ===============================================================================

    Args:
        matrix: ([runs,] stages, T): row s, column j is the return (or success rate) on task j after training
            on s tasks, best normalized. With T + 1 stages the first one is untrained; with T it is left out.
        single: ([runs,] T): the return of an agent trained on task j alone, for forward transfer.
        columns: the columns to return, in this order; all by default.

    Raises:
        BenchError: the arrays have another shape or a value that is not finite, or a column is unknown.

    Example:
        >>> metrics_of([[1.0, 0.0], [0.5, 1.0]]).set_index("metric")["mean"]["forgetting"]
        np.float64(0.5)
    """
    dtypes = {"metric": "str", **dict.fromkeys(("mean", "low", "high"), "float64")}
    check_columns(columns, dtypes)
    values = compute(matrix, single)
    rows = [(name, value.mean, value.low, value.high) for name, value in values.items()]
    return select_columns(typed(pd.DataFrame(rows, columns=list(dtypes)), dtypes), columns)


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

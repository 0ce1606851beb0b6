"""Scores of submissions as data frames: the metrics of each, and the boards that compare them."""

import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pandas as pd

from gym_extensions.catalog.groups import CORE, CORES, GROUPS, SUITES, Groups, TaskGroup, with_custom
from gym_extensions.catalog.protocol import BUDGETS, PROTOCOLS, STANDARD_BUDGET, stages
from gym_extensions.errors import BenchError, did_you_mean, require_known
from gym_extensions.results.frames import dtypes_of
from gym_extensions.scoring import pipeline
from gym_extensions.scoring.output import board_frames
from gym_extensions.scoring.pipeline import Paths, make_scorer, valid_scorecards
from gym_extensions.scoring.ranking.boards import BoardKey, CoreBoard, logs_on
from gym_extensions.scoring.ranking.core_board import core_board
from gym_extensions.scoring.ranking.group_board import board as board_of
from gym_extensions.submissions.landscapes import best, landscapes_of, summary
from gym_extensions.submissions.review import is_withdrawn, read_review


def metrics(submissions: Paths, *, groups: Groups = (), references: str | Path | None = None) -> pd.DataFrame:
    """Every metric of the submissions, one row per submission, group or suite, protocol and metric.

    ========  =======  =============================================================================
    column    dtype    value
    ========  =======  =============================================================================
    name      str      name of the submission's folder
    level     str      ``reported``, ``claimed``, ``verified`` or ``trained here``
    group     str      group id, or name of a suite
    protocol  str      ``sequential``, ``single`` or another one (docs/concepts.md)
    budget    str      name of the training budget
    runs      Int64    number of runs; missing for a suite, 0 for a reported submission
    metric    str      name of the metric (docs/metrics.md)
    mean      float64  mean over runs, in normalized return: 0 = floor, 1 = expert; may be missing
    low       float64  lower end of the 95 % interval; missing with one run or without a mean
    high      float64  upper end of the 95 % interval; missing with one run or without a mean
    why       str      why the mean or the interval is missing; else empty
    ========  =======  =============================================================================

    Args:
        submissions: a submission, a folder of submissions, or a list of these.
        groups: custom groups that the submissions may contain: TOML files or TaskGroup objects.
        references: the references file of the custom groups' tasks.

    Raises:
        BenchError: a path does not exist, or a submission has problems.
    """
    cards = valid_scorecards(submissions, make_scorer(groups, references))
    return board_frames.metrics_frame(cards.values())


def board(
    group: str | TaskGroup,
    submissions: Paths = "submissions",
    protocol: str = "sequential",
    budget: str = STANDARD_BUDGET,
    *,
    task_conditioned: bool = False,
    groups: Groups = (),
    references: str | Path | None = None,
) -> pd.DataFrame:
    """A board: the submissions with results on it, one per row.

    Ranked submissions are sorted by the protocol's first metric (final performance, or single-task
    performance), best first; the others follow, and at the end ``alone`` (``trpo`` on each task alone, with
    the budget ``300k``), ``random`` and ``zero``, computed from the references. Only the groups of the board
    are read.

    ================  =======  =====================================================================
    column            dtype    value
    ================  =======  =====================================================================
    rank_first        Int64    best possible rank by the first metric; missing without a rank
    rank_last         Int64    worst possible rank by the first metric; missing without a rank
    name              str      name of the submission's folder
    title             str      title of the submission
    level             str      ``reported``, ``claimed``, ``verified`` or ``trained here``
    evaluation        str      ``sampled`` or ``deterministic``: how actions are selected in evaluation
    runs              int64    number of runs; on a suite the fewest of its groups
    ranked            bool     whether the board ranks the submission
    why               str      why the submission is not ranked; else empty
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
        protocol: ``sequential``, ``single`` or another one (docs/concepts.md).
        budget: name of the training budget. The site has no board of the budget ``smoke``.
        task_conditioned: whether the agents observe the task in evaluation.
        groups: custom groups, as in :func:`metrics`.
        references: as in :func:`metrics`.

    Raises:
        BenchError: a group, protocol, budget or path is unknown, or a submission has problems.

    Warns:
        UserWarning: the board is empty, and the submissions have results with another budget.
    """
    scorer, group_id = _scorer_of(group, groups, references)
    require_known("protocol", protocol, PROTOCOLS, "protocol")
    require_known("budget", budget, BUDGETS, "budget")
    cards = list(valid_scorecards(submissions, scorer).values())
    key = BoardKey(group_id, protocol, budget, task_conditioned)
    found = board_of(cards, key, scorer.references)
    if not found.rows:
        budgets = sorted({log.budget for card in cards for log in logs_on(card, key).values()})
        if budgets and budget not in budgets:
            message = f"The board of {group_id}, {protocol}, budget {budget} is empty. The submissions have "
            warnings.warn(f"{message}the budget {', '.join(budgets)}.", UserWarning, stacklevel=2)
        found = replace(found, computed=())
    return board_frames.board_frame(found)


def _scorer_of(
    group: str | TaskGroup, groups: Groups, references: str | Path | None
) -> tuple[pipeline.Scorer, str]:
    """The scorer of a group, which may be a custom one, or suite; and the id or name of that."""
    if isinstance(group, TaskGroup):
        groups, group = (*with_custom(groups).values(), group), group.name
    scorer = make_scorer(groups, references)
    ids = {name: known.id for name, known in scorer.groups.items()}
    if group not in SUITES and group not in {*ids, *ids.values()}:
        hint = did_you_mean(str(group), [*ids, *SUITES])
        raise BenchError("unknown-group", f"There is no group or suite {group!r}.", "group", hint)
    group_id = ids.get(group, group)
    members = SUITES.get(group_id, (group_id,))
    return replace(scorer, only=tuple(name for name, id_ in ids.items() if id_ in members)), group_id


def core(submissions: Paths = "submissions") -> pd.DataFrame:
    """The core board: one row per method, over all groups of the core (docs/metrics.md).

    First the list without the task label in evaluation, then that with it (``observes_task``), which are
    ranked apart. In each, ranked methods come first, best first. The last rows, ``joint`` and ``alone``, are
    ``trpo`` trained on all tasks at once and on each alone; they have no rank. Only the groups of the core
    are read.

    =====================  =======  ================================================================
    column                 dtype    value
    =====================  =======  ================================================================
    rank_first, rank_last  Int64    best and worst possible rank; missing without a rank
    name, title, level     str      as on boards
    observes_task          bool     whether the agent observes the task in evaluation
    look                   int64    n: runs 0 to n − 1 of every group are compared
    next_look              Int64    the next look; missing after the last
    ranked, why            bool     whether the method is compared; why it is not (str)
    vs_first               str      ``separated``, ``equivalent`` or ``open``: against the first of its list
    vs_reference           str      the same against ``trpo``
    ``METRIC``             float64  mean over groups; also ``METRIC_low`` and ``METRIC_high``
    retention              float64  share of what was learned that is kept; also with ``_low`` and ``_high``
    forgetting_note        str      why little forgetting is no retention; else empty
    ``GROUP``              float64  final performance on each group, by its id; may be missing
    steps, cpu_seconds     float64  what one run of all groups takes; missing where it is not stated
    peak_memory_mb         float64  largest memory of a process
    stored_steps           Int64    most transitions stored at once
    parameters             Int64    parameters at the end of training
    notes                  str      what is not compared, in words
    =====================  =======  ================================================================

    The metrics are ``final_performance``, ``learning_performance``, ``forgetting`` and
    ``zero_shot_transfer``. ``submissions`` and the errors are those of :func:`metrics`.
    """
    return board_frames.core_frame(_core_board(submissions))


def core_pairs(submissions: Paths = "submissions") -> pd.DataFrame:
    """Every pair of ranked methods on the core board, for final performance and for forgetting.

    The columns are ``metric``, ``first``, ``second``, ``look``, ``paired``, the difference first − second as
    ``mean``, ``low`` and ``high`` (adjusted for all pairs and looks), the adjusted ``p_value``, ``verdict``
    (``separated``, ``equivalent`` or ``open``), ``exploratory`` and ``next_look``. docs/scorecard.md says
    more. ``submissions`` and the errors are those of :func:`metrics`.
    """
    return board_frames.core_pairs_frame(_core_board(submissions))


def core_variants(submissions: Paths = "submissions") -> pd.DataFrame:
    """How far the core board depends on its groups: scores and ranks without some, and by another mean.

    One row per variant and ranked method: ``variant`` (``without-Hopper``, ``without-wall``, …,
    ``interquartile-mean``), its ``title``, ``name``, ``observes_task``, the ``place`` by the mean in its
    list, ``rank_first`` and ``rank_last`` there, and the score as ``mean``, ``low`` and ``high`` (95 %).
    ``submissions`` and the errors are those of :func:`metrics`.
    """
    return board_frames.core_variants_frame(_core_board(submissions))


def order_effects(
    submissions: Paths = "submissions", *, groups: Groups = (), references: str | Path | None = None
) -> pd.DataFrame:
    """What of a score is due to the task, and what to its position in training (docs/metrics.md, "Order").

    One row per submission, group and level, where ``balanced`` runs fill the balanced square of the group.
    The arguments and errors are those of :func:`metrics`.

    ==========  =======  ==========================================================================
    column      dtype    value
    ==========  =======  ==========================================================================
    submission  str      name of the submission's folder
    group       str      group id
    budget      str      name of the training budget
    runs        int64    number of balanced runs; those beyond the last whole square do not count
    metric      str      ``final_performance`` or ``forgetting``
    kind        str      ``position``, ``task`` or ``share``
    level       str      the position from 1, the task id, or of a share ``position``, ``task``, ``rest``
    mean        float64  mean at equal tasks or positions; of a share, that of the squared deviations
    low, high   float64  ends of the 95 % interval over runs
    ==========  =======  ==========================================================================
    """
    cards = valid_scorecards(submissions, make_scorer(groups, references)).values()
    rows = (
        (
            *(card.name, group, score.budget, len(score.runs), metric, kind, str(level)),
            *(value.mean, value.low, value.high),
        )
        for card in cards
        for group, protocols in card.groups.items()
        if (score := protocols.get("balanced"))
        for metric, effects in score.order_effects.items()
        for kind, levels in {
            "position": enumerate(effects.position, 1),
            "task": zip(score.tasks, effects.task, strict=True),
            "share": effects.shares.items(),
        }.items()
        for level, value in levels
        if value.mean is not None
    )
    return board_frames.typed(rows, dtypes_of(order_effects))


def landscapes(submissions: Paths = "submissions") -> pd.DataFrame:
    """Returns between and beyond the tasks, where no agent was trained (docs/metrics.md, "Landscapes").

    One row per submission, group and share, from the landscapes in the folders of the submissions
    (a submission, a folder of submissions, or a list of these) but withdrawn ones. The best return depends
    on which are given.

    ==========  =======  ========================================================================
    column      dtype    value
    ==========  =======  ========================================================================
    submission  str      name of the submission's folder
    group       str      group id
    share       str      ``interpolation`` (between trained values) or ``extrapolation`` (beyond)
    runs        int64    number of runs
    mean        float64  share of the best return that any of these submissions has in a world
    low, high   float64  ends of the 95 % interval over runs; missing with one run
    ==========  =======  ========================================================================

    Raises:
        BenchError: a path is unknown, or a landscape or review cannot be read.
    """
    folders = pipeline.find_submissions(submissions)
    standing = [folder for folder in folders if not is_withdrawn(read_review(folder).decisions)]
    found = {folder.name: landscapes_of(folder) for folder in standing}
    top = best(found)
    rows = [
        (name, group.id, share, len(value.runs), value.mean, value.low, value.high)
        for name, of_submission in found.items()
        for group in GROUPS.values()
        if group.id in of_submission
        for share, value in summary(of_submission[group.id], group, top).items()
    ]
    return board_frames.typed(rows, dtypes_of(landscapes))


def _core_board(submissions: Paths) -> CoreBoard | None:
    return core_board(list(valid_scorecards(submissions, make_scorer(only=("core",))).values()))


def scores(
    submissions: Paths,
    group: str | TaskGroup,
    protocol: str = "sequential",
    *,
    stage: int | None = None,
    groups: Groups = (),
    references: str | Path | None = None,
) -> pd.DataFrame:
    """The mean return of every run, stage and task, raw and normalized: what the metrics are made of.

    ==========  =======  ===========================================================================
    column      dtype    value
    ==========  =======  ===========================================================================
    submission  str      name of the submission's folder
    group       str      group id
    protocol    str      ``sequential``, ``single`` or another one (docs/concepts.md)
    run         int64    training seed
    stage       int64    number of tasks trained so far: 0 untrained; 1 in the other protocols
    task        str      task id, in training order
    return      float64  mean over the 20 episodes
    normalized  float64  the same: 0 = floor, 1 = expert; missing for a task without an expert
    ==========  =======  ===========================================================================

    Args:
        stage: of which stage; -1 for the last one, None for all.

    The other arguments are those of :func:`board`. Suites are not accepted.

    Raises:
        BenchError: a group, protocol or path is unknown, the group is a suite, or a submission has problems.
    """
    scorer, group_id = _scorer_of(group, groups, references)
    if group_id in SUITES:
        hint = f"Name one of its groups: {', '.join(SUITES[group_id])}."
        raise BenchError("not-a-group", f"{group_id!r} is a suite, not a group.", "group", hint)
    require_known("protocol", protocol, PROTOCOLS, "protocol")
    known = (None, -1, *stages(protocol, len(scorer.groups[scorer.only[0]].tasks)))
    require_known("stage", str(stage), list(map(str, known)), "stage")
    rows = (
        (card.name, group_id, protocol, run, number, task, mean, score.reference[task].normalize(mean))
        for card in valid_scorecards(submissions, scorer).values()
        if (score := card.log(group_id, protocol))
        for run, matrix in zip(score.runs, score.return_matrix, strict=True)
        for number, means in zip(stages(protocol, len(score.tasks)), matrix, strict=True)
        for task, mean in zip(score.tasks, means, strict=True)
    )
    frame = board_frames.typed(rows, dtypes_of(scores))
    if stage is not None:
        frame = frame[frame["stage"] == (frame["stage"].max() if stage == -1 else stage)]
    return frame.reset_index(drop=True)


def score_matrix(
    submission: str | Path,
    group: str | TaskGroup | Sequence[str | TaskGroup],
    protocol: str = "sequential",
    values: str = "normalized",
    *,
    stage: int = -1,
    groups: Groups = (),
    references: str | Path | None = None,
) -> pd.DataFrame:
    """The mean return of every run on every task after one stage, (runs, tasks), which rliable expects.

    The rows are the runs (index ``run``), the columns the tasks in training order (``task``);
    ``to_numpy()`` gives the array.

    Args:
        submission: one submission.
        group: a group, several groups, a suite, or ``core``. Of several groups: the tasks of one group after
            the other, and the runs that every group has.
        stage: one stage; -1 for the last one.
        values: ``normalized`` (0 = floor, 1 = expert) or ``return``.

    The other arguments are those of :func:`scores`.

    Raises:
        BenchError: as in :func:`scores`; or there is not exactly one submission with runs of every group.

    Example:
        >>> runs, tasks = score_matrix("submissions/trpo", "hopper-gravity").shape
        >>> tasks
        5
    """
    require_known("values", values, ("normalized", "return"), "values")
    if isinstance(group, str):
        group = {**SUITES, "core": CORES[CORE]}.get(group, (group,))
    several = (group,) if isinstance(group, TaskGroup) else group
    parts = [
        scores(submission, each, protocol, stage=stage, groups=groups, references=references)
        for each in several
    ]
    found = [sorted(set(part["submission"])) for part in parts]
    if len({name for names in found for name in names}) != 1 or not all(found):
        which = (each.id if isinstance(each, TaskGroup) else each for each in several)
        text = [f"{each}: {', '.join(names) or 'none'}" for each, names in zip(which, found, strict=True)]
        message = f"The submissions with runs at this stage are not one ({'; '.join(text) or 'no group'})."
        raise BenchError(
            "no-matrix", message, str(submission), "Name one submission with runs of every group."
        )
    matrices = [
        part.pivot(index="run", columns="task", values=values)[list(dict.fromkeys(part["task"]))]
        for part in parts
    ]
    return pd.concat(matrices, axis=1, join="inner")

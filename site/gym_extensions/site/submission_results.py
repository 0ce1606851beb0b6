"""A submission as pages show it: its facts in words, its results on each group, and tables of returns."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import groupby

from markupsafe import Markup

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.metrics.formulas import COLUMNS, LEARNING
from gym_extensions.metrics.values import LEAST_LEARNED, NOTHING_LEARNED, MetricValue, learned_nothing
from gym_extensions.references import experts
from gym_extensions.scoring import scorecard
from gym_extensions.scoring.group_score import (
    GroupScore,
    ReferenceValue,
    RunProvenance,
    StageScore,
    SuiteScore,
    TaskChange,
)
from gym_extensions.scoring.scorecard import ManifestSummary, Scorecard
from gym_extensions.site import paths
from gym_extensions.site.text import count, digits_for, fixed, grouped, variation
from gym_extensions.submissions.review import (
    CLAIMED,
    REPORTED,
    TRAINED_HERE,
    VERIFIED,
    how_repeated,
    is_verified,
)

SEQUENTIAL = "sequential"
NO_LOG = GroupScore(level="claimed", budget="", runs=(), tasks=(), metrics={}, reference={}, return_matrix=())
NO_METRIC = MetricValue(why="not part of this protocol")
STEPS = 10
MAX_CELLS = 3_000
"""Cells of all runs' matrices on one page; those of larger groups are in the data alone."""
CHANGE_STEPS = 5
Points = tuple[tuple[float, float], ...]
Matrix = tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class SubmissionResult:
    """The scores of a scorecard with their group or suite and protocol; a suite has only metrics."""

    group: str
    protocol: str
    score: GroupScore | SuiteScore
    is_own: bool = False  # whether it is the author's, and the page shows runs that were trained here, too

    @property
    def id(self) -> str:
        """Its anchor on the page of the submission."""
        return f"{self.group}-{'own' if self.is_own else self.protocol}"

    @property
    def detail(self) -> GroupScore:
        """The scores of a group; of a suite, which has only metrics, all is empty."""
        return self.score if isinstance(self.score, GroupScore) else NO_LOG

    def metric(self, name: str) -> MetricValue:
        """The named metric; one without a value if the protocol does not have it."""
        return self.score.metrics.get(name, NO_METRIC)

    @property
    def runs(self) -> tuple[int, ...]:
        """Training seeds; empty for a suite."""
        return self.detail.runs

    @property
    def made(self) -> tuple[tuple[RunProvenance, ...], ...]:
        """How the runs were made; runs with the same command, commit, versions and steps together."""
        same = groupby(
            self.detail.provenance, key=lambda made: (made.command, made.commit, made.versions, made.steps)
        )
        return tuple(tuple(members) for _, members in same)

    @property
    def tasks(self) -> tuple[str, ...]:
        """Task ids in training order; empty for a suite."""
        return self.detail.tasks

    @cached_property
    def profile(self) -> Points:
        """Points of the performance profile, up to a score of 2; empty without one."""
        return self.detail.profile.points if self.detail.profile else ()

    @cached_property
    def stage_matrices(self) -> tuple[Matrix, ...]:
        """Mean raw returns [run][stage][task] of a sequential log; else empty."""
        return self.detail.return_matrix if self.protocol == SEQUENTIAL else ()

    @cached_property
    def mean_matrix(self) -> Matrix:
        """Mean raw returns [stage][task], averaged over runs."""
        return tuple(tuple(cell.mean_return for cell in row) for row in self.stages)

    @cached_property
    def matrix_digits(self) -> int:
        """Digits after the point in all matrices: none if returns reach the hundreds."""
        rows = (*self.final_returns, *(stage for run in self.stage_matrices for stage in run))
        return digits_for(10 * cell for row in rows for cell in row)

    @cached_property
    def final_returns(self) -> Matrix:
        """Mean raw returns [run][task] of a single or joint log; else empty."""
        return () if self.protocol == SEQUENTIAL else tuple(run[-1] for run in self.detail.return_matrix)

    @cached_property
    def success_rates(self) -> tuple[tuple[float | None, ...], ...]:
        """Success rates [stage][task], averaged over runs; empty if no task of the group defines success."""
        rates = tuple(tuple(cell.success_rate for cell in row) for row in self.detail.stages)
        return rates if any(rate is not None for row in rates for rate in row) else ()

    @property
    def stages(self) -> tuple[tuple[StageScore, ...], ...]:
        """``[stage][task]`` scores of a sequential log; else empty."""
        return self.detail.stages if self.protocol == SEQUENTIAL else ()

    @cached_property
    def learned_nothing(self) -> bool:
        """Whether the agent learned nothing that it could forget."""
        return learned_nothing(self.score.metrics)

    @property
    def why_no_metrics(self) -> str:
        """The reason why every metric is missing; empty if one has a value or reasons differ."""
        reasons = {value.why if value.mean is None else "" for value in self.score.metrics.values()}
        return next(iter(reasons)) if len(reasons) == 1 else ""

    @cached_property
    def open_tasks(self) -> tuple[str, ...]:
        """The tasks without an expert, in training order."""
        known = self.detail.reference
        return tuple(task for task in self.tasks if task in known and known[task].open)

    @cached_property
    def provisional_tasks(self) -> tuple[tuple[str, str], ...]:
        """The tasks whose expert is provisional, in training order, and why it is."""
        known = self.detail.reference
        pairs = ((task, known[task].provisional) for task in self.tasks if task in known)
        return tuple((task, why) for task, why in pairs if why)


@lru_cache(maxsize=1024)
def group_order(group_id: str) -> tuple[int, str]:
    """Sorts groups in the catalog's order, others by name after them."""
    ids = [group.id for group in GROUPS.values()]
    return (ids.index(group_id) if group_id in ids else len(ids), group_id)


def results_of(found: Mapping[str, Mapping[str, GroupScore | SuiteScore]]) -> tuple[SubmissionResult, ...]:
    """The scores of every group, or of every suite, of a scorecard, and every protocol."""
    results = [
        SubmissionResult(name, p, score) for name, scores in found.items() for p, score in scores.items()
    ]
    return tuple(sorted(results, key=lambda each: (group_order(each.group), PROTOCOLS.index(each.protocol))))


def own_results(card: Scorecard) -> tuple[SubmissionResult, ...]:
    """The results of the author's own runs, where others were trained here."""
    found = [SubmissionResult(name, SEQUENTIAL, score, is_own=True) for name, score in card.own.items()]
    return tuple(sorted(found, key=lambda each: group_order(each.group)))


def on_groups(card: Scorecard) -> tuple[SubmissionResult, ...]:
    """The results of a submission on groups; last those of the author's own runs beside others."""
    return results_of(card.groups) + own_results(card)


def shown_columns(found: Sequence[SubmissionResult]) -> tuple[str, ...]:
    """The metrics of a board of which one of its results has a value; the first one always."""
    first, *others = COLUMNS[found[0].protocol]
    return (first, *(name for name in others if any(each.metric(name).mean is not None for each in found)))


def missing_reasons(results: Sequence[SubmissionResult]) -> tuple[str, ...]:
    """Why values in the shown columns of results of one protocol are missing, each reason once, in order."""
    values = (result.metric(name) for result in results for name in shown_columns(results))
    return tuple(dict.fromkeys(value.why for value in values if value.mean is None))


def separate_groups(card: Scorecard) -> tuple[str, ...]:
    """The groups whose results have a page of their own: all, if there are several."""
    return tuple(sorted(card.groups, key=group_order)) if len(card.groups) > 1 else ()


def page_of(card: Scorecard, group: str) -> str:
    """The page with the results of a submission on a group; of a suite, its own page."""
    is_apart = group in separate_groups(card)
    return paths.results_path(card.name, group) if is_apart else paths.submission_path(card.name)


def origins(submission: str, result: SubmissionResult) -> tuple[experts.Origin, ...]:
    """The policies of a log that are experts or their ancestors, by run and stage."""
    group = result.group.rpartition("-v")[0]
    if result.detail.level == TRAINED_HERE:  # experts are from authors' own runs
        return ()
    return tuple(
        sorted(experts.origins().get((submission, group, result.protocol), ()), key=lambda each: each[1:3])
    )


def nothing_to_forget(result: SubmissionResult) -> str:
    """The note beside the forgetting of an agent that learned nothing that it could forget."""
    uncertain = (result.metric(LEARNING.name).mean or 0.0) >= LEAST_LEARNED
    return NOTHING_LEARNED + (f", as far as {count(len(result.runs), 'run')} can show" if uncertain else "")


def table_digits(result: SubmissionResult) -> int:
    """Digits after the point in the paper's table of a result: two for a printed table."""
    if result.detail.printed_total:
        return 2
    cells = [cell for row in result.detail.paper_table for cell in row.cells() if cell]
    return digits_for(cell.mean / 10 for cell in cells)


def tint(value: float, reference: ReferenceValue | None, top: float = 1.0) -> str:
    """A class of the style sheet for a raw return: ``h0`` (floor) … ``h10``, ``below`` or ``open``.

    ``top`` is the score with the strongest tint, the highest of the matrix or 1 if that is higher.
    """
    share = reference.normalize(value) if reference else None
    return "open" if share is None else shade(share / top)


def shade(share: float) -> str:
    """The class of a share of the strongest tint, to the nearest tenth."""
    level = math.floor(share * STEPS + 0.5)
    return "below" if level < 0 else f"h{min(level, STEPS)}"


def tinted(rows: Sequence[Sequence[float]], result: SubmissionResult) -> list[list[tuple[str, str]]]:
    """The cells of a matrix ``[row][task]`` of raw returns: tint and text of each."""
    top, digits = result.detail.top_score, result.matrix_digits
    references = [result.detail.reference.get(task) for task in result.tasks]
    return [
        [(tint(value, each, top), fixed(value, digits)) for value, each in zip(row, references, strict=True)]
        for row in rows
    ]


def stage_rows(cells: Sequence[Sequence[float]], result: SubmissionResult) -> Markup:
    """The rows of a matrix ``[stage][task]``, each with the task that was trained last; that cell is marked.

    They are written here, because a large site has millions of cells and a template needs longer for each.
    """
    titles = [variation(task, result.tasks) for task in result.tasks]
    rows = []
    for stage, row in enumerate(tinted(cells, result)):
        title = f"{stage} {titles[stage - 1]}" if stage else "no training"
        body = "".join(
            f'<td class="{kind}{" trained" if at == stage else ""}">{text}'
            for at, (kind, text) in enumerate(row, 1)
        )
        rows.append(f'<tr><th scope="row">{title}</th>\n{body}</tr>\n')
    return Markup("".join(rows))


def shows_each_run(result: SubmissionResult) -> bool:
    """Whether the page has the matrix of every run: at most some thousand cells, or it would be too large."""
    return len(result.runs) * len(result.tasks) ** 2 <= MAX_CELLS


def change_tint(change: TaskChange) -> str:
    """Classes of the style sheet: ``lost1`` … ``lost5``, ``kept``, ``won1`` … ``won5``.

    The strongest tint is the whole distance from floor to expert. It is ``raw`` without an expert. ``unsure``
    is added where the interval contains 0 or there is none.
    """
    unsure = "" if change.is_certain else " unsure"
    mean = change.mean
    if mean is None or not change.normalized:
        return f"raw{unsure}"
    level = min(CHANGE_STEPS, math.floor(abs(mean) * CHANGE_STEPS + 0.5))
    kind = "kept" if level == 0 else f"{'lost' if mean < 0 else 'won'}{level}"
    return kind + unsure


LEVELS = {
    REPORTED: "Published elsewhere without logs, so nothing can be checked.",
    CLAIMED: (
        "The files follow the rules, but the results are not verified. Reasons: no runs, no policies, not "
        "yet checked, or a failed check."
    ),
    VERIFIED: (
        "The board’s own machine ran the policies of every run on seeds that did not exist when they were "
        "submitted, and their returns agree with the log. The page of the submission says how many logged "
        "episodes were repeated, and how closely. How the policies were made is the author’s statement; a "
        "run that was trained again from its seed and agrees is marked as reproduced."
    ),
    TRAINED_HERE: (
        "The project trained the runs itself, from the author’s code, on seeds that followed from the merge. "
        "Nobody could choose among runs, train longer, or see the seeds."
    ),
}
"""What each level of a submission means, from the lowest."""
NOT_STATED = "not stated"


def task_label(manifest: ManifestSummary) -> str:
    """When the agent receives the task label: ``none``, ``training``, ``evaluation`` or both."""
    observes = manifest.observes
    times = {"training": observes.task_in_training, "evaluation": observes.task_in_evaluation}
    return " and ".join(name for name, received in times.items() if received) or "none"


def stored(manifest: ManifestSummary) -> str:
    """The maximum number of transitions that the agent stores."""
    return grouped(manifest.memory.stored_steps) if manifest.memory else NOT_STATED


def dated(card: Scorecard) -> str:
    """When a submission was trained here, accepted or last verified, such as ``accepted on 2026-11-22``."""
    if card.level == TRAINED_HERE and card.training:
        return f"trained on {card.training.date}"
    if card.accepted:
        return f"accepted on {card.accepted}"
    return next((f"verified on {each.date}" for each in reversed(card.verifications) if each.passed), "")


def has_policies(card: Scorecard) -> bool:
    """Whether a run of a whole scorecard publishes its policies."""
    scores = [score for protocols in card.groups.values() for score in protocols.values()]
    return is_verified(card.level) or any(made.policies for score in scores for made in score.provenance)


def checked(card: Scorecard) -> str:
    """How a submission was verified, in a sentence or two; what its level means if it was not."""
    if card.level == CLAIMED:
        reasons = (log.why_claimed for protocols in card.groups.values() for log in protocols.values())
        why = next(filter(None, reasons), "Not verified yet." if card.groups else scorecard.NO_RUNS)
        return f"Claimed: the files follow the rules. {why}"
    if not is_verified(card.level) or card.level == TRAINED_HERE:
        return LEVELS[card.level] if card.level else ""
    passed = [found for found in card.verifications if found.passed and found.current]
    whole = [found for found in passed if found.current == found.runs]  # episodes are not counted by run
    episodes, repeated = (sum(getattr(found, name) for found in whole) for name in ("episodes", "repeated"))
    runs = sum(found.current for found in passed)
    policies = f"the policies of {count(runs, 'run')}{' of the author' if card.own else ''}"
    text = f"Verified: {policies} were run on new seeds and agree with the logs"
    if episodes:
        how = " or ".join(dict.fromkeys(how_repeated(found.runtime) for found in whole if found.episodes))
        text += f"; {grouped(repeated)} of {grouped(episodes)} logged episodes were repeated {how}"
    if card.arithmetic == 1:
        text += " (on the type of processor that logged them)"
    if episodes > repeated:
        text += f", the other {grouped(episodes - repeated)} differ"
    if any(found.retrained for found in passed):
        text += ". A run was trained again and agrees"
    if card.core and card.core.trained_here:
        text += ". The project trained the sequential runs on the core itself"
    return f"{text}."


def parameters(card: Scorecard) -> str:
    """At the end of training, in the core and in the largest group; at the start, too, if it differs.

    Runs state the largest network of their submission, which need not be that of their own group.
    """
    if card.manifest is None or not (memory := card.manifest.memory):
        return NOT_STATED
    on_core, largest = card.core.cost.parameters if card.core else None, memory.parameters_last
    if on_core is None or on_core == largest:
        return " → ".join(map(grouped, dict.fromkeys((memory.parameters_first, largest))))
    return f"{grouped(on_core)} on the core, {grouped(largest)} in the largest group"


def facts(card: Scorecard) -> list[tuple[str, str]]:
    """What the manifest states on training and evaluation, as (label, value); nothing if it is refused."""
    if (manifest := card.manifest) is None:
        return []
    tuning = NOT_STATED
    if spent := manifest.tuning:  # the steps for choosing the settings
        on = f" on {', '.join(spent.tasks)}" if spent.tasks else ""
        tuning = f"{grouped(spent.steps)} steps{on}" if spent.steps else "none declared"
    steps = "counted by the training loop" if card.steps_counted else "claimed"
    if card.training and not card.steps_counted:
        steps = "claimed of the author’s own runs, counted of those trained here"
    return [
        ("Algorithm", manifest.protocol.algorithm),
        ("Actions in evaluation", manifest.protocol.evaluation),
        *([("Training steps", steps)] if card.groups else []),
        ("Task label", task_label(manifest)),
        ("Task boundaries", "observed" if manifest.observes.boundaries else "not observed"),
        ("Batch or replay buffer", stored(manifest)),
        ("Parameters", parameters(card)),
        ("Tuning", tuning),
    ]

"""Builds boards, which rank the submissions of one group or suite, protocol and budget.

A board is made from scorecards and the references alone. What it adds (ranks, differences, rows of the
references) belongs to the board and may change when a submission joins; the scores never move.
"""

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from itertools import combinations, product

from gym_extensions.catalog.groups import GROUPS, SUITES
from gym_extensions.catalog.protocol import FULL_SUBMISSION_RUNS, PROTOCOLS, STANDARD_BUDGET
from gym_extensions.metrics import formulas, statistics, values
from gym_extensions.metrics.formulas import BOARD_METRICS, BY_NAME, COLUMNS, FORGETTING, NEEDS, Metric
from gym_extensions.metrics.statistics import Summary, summary
from gym_extensions.metrics.values import MetricValue
from gym_extensions.references import ALONE, References, load_references, trained_alone
from gym_extensions.scoring.group_score import GroupScore
from gym_extensions.scoring.ranking import boards as documents
from gym_extensions.scoring.ranking.boards import BoardKey, BoardMetric, BoardRow, Difference, Versus
from gym_extensions.scoring.ranking.copies import COPY, alike_on, duplicates, related_submissions
from gym_extensions.scoring.ranking.core_board import core_board
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.scoring.submission.suites import estimate
from gym_extensions.submissions.problem import count
from gym_extensions.submissions.review import REPORTED, TRAINED_HERE, Level, is_verified

MAX_PAIRED = 60
"""Submissions of a board whose differences it lists."""
MAX_BEST = 5
"""Submissions that are listed as the best ones on a task."""
Summaries = Mapping[str, Summary | None]
"""The summaries over runs of a submission by metric; None where it has no value."""


def boards(cards: Sequence[Scorecard], references: References | None = None) -> documents.BoardsDocument:
    """Every board of the scorecards. Withdrawn submissions are on none.

    ``references`` are those of the computed rows, the current benchmark version's where None.
    """
    references = references or load_references()
    made = tuple(board(cards, key, references) for key in documents.board_keys(cards))
    return documents.BoardsDocument(core=core_board(cards), boards=made, best=best_by_task(made, cards))


def best_by_task(
    made: Sequence[documents.Board], cards: Sequence[Scorecard]
) -> dict[str, tuple[documents.TaskBest, ...]]:
    """The verified submissions with the highest return at the end of sequential training, by task id."""
    by_name, found = {card.name: card for card in cards}, dict[str, list[documents.TaskBest]]()
    for each in made:
        if each.protocol != "sequential" or each.group in SUITES:
            continue
        for row in each.rows:
            card = by_name[row.name]
            if row.duplicate_of or not is_verified(card.level):
                continue
            facts = (row.name, row.title, each.id, each.group, each.budget, each.task_conditioned)
            for returns in card.groups[each.group][each.protocol].paper_table:
                if end := returns.fully_trained:
                    after = returns.after_env_training
                    best = documents.TaskBest(*facts, after.mean if after else None, end.mean)
                    found.setdefault(returns.task, []).append(best)
    return {
        task: tuple(sorted(rows, key=lambda best: (-best.end, best.name))[:MAX_BEST])
        for task, rows in found.items()
    }


def board(cards: Sequence[Scorecard], key: BoardKey, references: References | None = None) -> documents.Board:
    """One board. Ranked submissions come first, best first by their first metric, then those without a rank.

    A submission with most episodes of another follows it, without a rank. Scorecards that are not on the
    board are left out. ``references`` are as in :func:`boards`.
    """
    references = references or load_references()
    by_name = {card.name: card for card in cards if documents.lookup(card, key)}
    copies, related = duplicates(list(by_name.values()), key), related_submissions(by_name)
    metrics = BOARD_METRICS[key.protocol]
    first = metrics[0]
    summaries = {
        name: {each.name: estimate(card.groups, key.groups, key.protocol, each) for each in metrics}
        for name, card in by_name.items()
    }
    with_logs = next((card for card in by_name.values() if card.level != REPORTED), None)
    tasks = [log.tasks for log in documents.logs_on(with_logs, key).values()] if with_logs else []
    computed = computed_rows(key, references, tasks, by_name) if tasks else ()
    alone = next((row.metrics[first.name] for row in computed if row.name == ALONE), values.Estimate())
    alike = alike_on([card for name, card in by_name.items() if name not in copies], key, first.name)
    unsorted = []
    for name, card in by_name.items():
        row = _row(card, key, copies.get(name), summaries[name], alone)
        unsorted.append(replace(row, alike=alike.get(name, ""), related=related[name]))
    made = _sorted(unsorted, first)
    ranks, versus = dict[str, dict[str, tuple[int, int]]](), dict[str, list[Versus | None]]()
    for metric in metrics:
        ranked = _ranked(made, summaries, metric)
        separated = statistics.significant_pairs(list(ranked.values()))
        possible = statistics.rank_intervals(list(ranked.values()), separated, metric.better)
        ranks[metric.name] = dict(zip(ranked, possible, strict=True))
        if metric is first:
            versus = _versus(ranked, separated)
    rows = []
    for row in made:
        found = {each: replace(value, rank=ranks[each].get(row.name)) for each, value in row.metrics.items()}
        vs_next, vs_leader = versus.get(row.name, (None, None))
        rows.append(replace(row, metrics=found, vs_next=vs_next, vs_leader=vs_leader))
    values_of = ((row.metrics.get(FORGETTING.name), row.name) for row in rows)
    forgetting = [(value.mean or 0.0, name) for value, name in values_of if value and value.rank]
    two = combinations([row.name for row in rows[:MAX_PAIRED]], 2)
    pairs = (_pair(one, other, summaries[one], summaries[other]) for one, other in two)
    return documents.Board(
        group=key.group,
        published=key.group in SUITES or key.group in {group.id for group in GROUPS.values()},
        protocol=key.protocol,
        budget=key.budget,
        task_conditioned=key.task_conditioned,
        ranked=sum(row.ranked for row in rows),
        rows=tuple(rows),
        computed=computed,
        pairs=tuple(pair for pair in pairs if pair.metrics),
        lead=_lead(rows, first),
        least_forgetting=min(forgetting)[1] if forgetting else None,
    )


def _ranked(
    rows: Sequence[BoardRow], summaries: Mapping[str, Summaries], metric: Metric
) -> dict[str, Summary]:
    """The submissions that are ranked on a metric, in the order of the board."""
    eligible = [row.name for row in rows if row.ranked and not row.metrics[metric.name].rank_note]
    found = {name: summaries[name][metric.name] for name in eligible if metric.better}
    return {name: each for name, each in found.items() if each}


def _versus(ranked: Mapping[str, Summary], separated: statistics.Mask) -> dict[str, list[Versus | None]]:
    """Each ranked submission, by name, against the next one and against the first one."""
    names, means = list(ranked), list(ranked.values())

    def against(place: int, other: int) -> Versus | None:
        above, below = sorted((place, other))
        if above == below or below == len(names):
            return None
        difference = Difference.of(means[above], means[below])
        return Versus(names[other], difference, bool(separated[above, below]))

    return {name: [against(place, place + 1), against(place, 0)] for place, name in enumerate(names)}


def _lead(rows: Sequence[BoardRow], metric: Metric) -> documents.Lead | None:
    """The first ranked submission, or if none is ranked the first with a score."""
    scored = [row for row in rows if row.metrics[metric.name].mean is not None]
    ranked = [row for row in scored if row.ranked]
    if not scored:
        return None
    value, *others = (row.metrics[metric.name] for row in ranked or scored)
    return documents.Lead((ranked or scored)[0].name, _certainty(value, others, is_ranked=bool(ranked)))


def _certainty(value: BoardMetric, others: Sequence[BoardMetric], *, is_ranked: bool) -> str:
    """How certain a lead is: of ranked submissions by their rank intervals, of others by their intervals."""
    if not others:
        return "It is the only ranked submission." if is_ranked else "It is the only submission with a score."
    if is_ranked:
        best, worst = value.rank or (1, 1)
        if best == worst:
            return "It is significantly better than every other ranked submission (95\u202f% confidence)."
        return f"No significant difference from {count(worst - best, 'other ranked submission')}."
    if value.ends is None:
        return "It has one run, so its uncertainty is unknown."
    overlapping = sum((top.ends[1] if top.ends else top.mean or 0.0) >= value.ends[0] for top in others)
    if not overlapping:
        return "Its interval lies above those of all other submissions."
    names = "another submission" if overlapping == 1 else f"{overlapping} others"
    return f"Its interval overlaps with {names}, so the order may be due to chance."


def pairs_across(
    first: documents.Board, second: documents.Board, cards: Mapping[str, Scorecard]
) -> tuple[documents.Pair, ...]:
    """The differences of the first submissions of two boards of a group, of the metrics that pages show."""

    def on(board: documents.Board) -> dict[str, Summaries]:
        place, metrics = ((board.group,), board.protocol), COLUMNS[board.protocol]
        return {
            row.name: {each: estimate(cards[row.name].groups, *place, BY_NAME[each]) for each in metrics}
            for row in board.rows[:MAX_PAIRED]
        }

    pairs = product(on(first).items(), on(second).items())
    return tuple(_pair(one, other, ours, theirs) for (one, ours), (other, theirs) in pairs)


def _pair(first: str, second: str, ours: Summaries, theirs: Summaries) -> documents.Pair:
    both = ((metric, a, theirs[metric]) for metric, a in ours.items())
    return documents.Pair(first, second, {metric: Difference.of(a, b) for metric, a, b in both if a and b})


def _why_not_ranked(logs: Sequence[GroupScore], level: Level, first: MetricValue, copied: str | None) -> str:
    if level == REPORTED:
        return "Reported from a publication: no logs."
    if copied:
        return COPY.format(copied)
    if not is_verified(level):
        return f"Claimed: {next(filter(None, (log.why_claimed for log in logs)), 'not verified.')}"
    if min(len(log.runs) for log in logs) < FULL_SUBMISSION_RUNS:
        return f"Fewer than {FULL_SUBMISSION_RUNS} runs."
    return first.why if first.mean is None else ""


def _rank_note(
    card: Scorecard, key: BoardKey, metric: Metric, summary: Summary | None, retention_note: str
) -> str:
    """Why a submission with a rank and a value has no rank on this metric; empty if it has one."""
    if retention_note and metric is FORGETTING:
        return retention_note
    for protocol in metric.needs:
        if protocol in PROTOCOLS and not is_verified(documents.board_level(card, key, protocol)):
            return f"the {NEEDS[protocol]} are not verified"
    is_short = summary is not None and summary.runs < FULL_SUBMISSION_RUNS
    return f"fewer than {FULL_SUBMISSION_RUNS} runs" if is_short else ""


def _row(
    card: Scorecard, key: BoardKey, copied: str | None, summaries: Summaries, alone: values.Estimate
) -> BoardRow:
    logs = list(documents.logs_on(card, key).values())
    manifest, score = card.manifest, documents.lookup(card, key)
    assert manifest is not None and score is not None, "it is on the board"
    level, metrics = documents.board_level(card, key), BOARD_METRICS[key.protocol]
    why = _why_not_ranked(logs, level, score.metrics[metrics[0].name], copied)
    retained = values.retention_note(score.metrics, alone)
    return BoardRow(
        name=card.name,
        title=card.title,
        level=level,
        runs=min(len(log.runs) for log in logs),
        ranked=not why,
        why=why,
        steps_counted=card.steps_counted or level == TRAINED_HERE,
        evaluation=manifest.protocol.evaluation,
        authors=manifest.authors,
        accepted=card.accepted,
        observes=manifest.observes,
        memory=manifest.memory,
        metrics={
            each.name: BoardMetric.of(
                score.metrics[each.name], _rank_note(card, key, each, summaries[each.name], retained)
            )
            for each in metrics
        },
        duplicate_of=copied,
    )


def _sorted(submissions: Sequence[BoardRow], metric: Metric) -> list[BoardRow]:
    """Ranked submissions, best first, then the others; an identical one follows its original."""
    rows = documents.best_first(submissions, metric)
    places = {row.name: place for place, row in enumerate(rows)}
    return sorted(rows, key=lambda row: (places[row.duplicate_of or row.name], bool(row.duplicate_of)))


FROM_FLOORS = "Computed from the mean returns of the floors, which have no runs and no curves."
FLOORS = {"random": "Random actions", "zero": "Zero actions"}
"""The agents of the floor, by name, with their titles."""
ONLY_FINAL = "It was trained on every task alone: only its returns at the end are known."


def computed_rows(
    key: BoardKey, references: References, groups: Sequence[Sequence[str]], names: Collection[str]
) -> tuple[documents.ComputedRow, ...]:
    """The reference agent on each task alone, and the agents of the floor, as far as they are known.

    ``groups`` are the task ids of each group. A submission called ``alone`` among ``names`` takes the row's
    place.
    """
    submissions = []
    has_alone = key.budget == STANDARD_BUDGET and ALONE not in names
    if has_alone and (alone := alone_values(groups, references, key.protocol)):
        rows = {name: BoardMetric.of(value) for name, value in alone.items()}
        submissions.append(documents.ComputedRow(ALONE, "Each task alone", rows))
    for name, title in FLOORS.items():
        of_groups = [floor_values(name, each, references, key.protocol) for each in groups]
        if not all(of_groups):
            continue
        metrics = {}
        for metric in BOARD_METRICS[key.protocol]:
            means = [mean for each in of_groups if (mean := each[metric.name]) is not None]
            mean = statistics.mean(means) if len(means) == len(of_groups) else None
            metrics[metric.name] = BoardMetric(mean, None, None, FROM_FLOORS)
        submissions.append(documents.ComputedRow(name, title, metrics))
    return tuple(submissions)


def floor_values(
    agent: str, task_ids: Sequence[str], references: References, protocol: str
) -> dict[str, float | None]:
    """The metrics of an agent of the floor on a group, by name: it ignores observations and never learns.

    Its return on a task is the same after every stage and alone, so that differences of stages are 0. There
    are no runs: what is computed from episodes or curves is None. Empty where a task has no reference or no
    mean return of that agent.
    """
    known = [references.tasks.get(task) for task in task_ids]
    if any(reference is None or agent not in reference.floor.agents for reference in known):
        return {}
    scored = {j: each for j, each in enumerate(known, 1) if each and not each.open}
    p = {j: each.normalize(each.floor.agents[agent].mean) for j, each in scored.items()}
    T = len(task_ids)
    stages = {(s, j): value for s in range(T + 1) for j, value in p.items()}
    run = formulas.NormalizedRun(T=T, scored=tuple(p), normalized_returns=stages, single_task=p)
    found: dict[str, float | None] = {}
    for metric in BOARD_METRICS[protocol]:
        try:
            found[metric.name] = metric.of_run(run)
        except KeyError:
            found[metric.name] = None
    if formulas.JOINT_GAP.name in found and p:
        found[formulas.JOINT_GAP.name] = 0.0
    return found


def alone_values(
    groups: Sequence[Sequence[str]], references: References, protocol: str
) -> dict[str, MetricValue]:
    """The metrics of the reference agent that was trained on each task of a board alone, by name.

    Its score is the mean over tasks, then over groups. Its standard error is that over the runs of every
    task, which are independent, and of the experts. Empty where a task has no reference or the agent no runs.
    """
    known = trained_alone()
    if any(task not in references.tasks or task not in known for tasks in groups for task in tasks):
        return {}
    scores: list[dict[str, Summary]] = []
    for tasks in groups:
        scored = {task: references.tasks[task] for task in tasks if not references.tasks[task].open}
        runs = {task: [each.normalize(run.mean) for run in known[task].runs] for task, each in scored.items()}
        scores.append({task: summary(means) for task, means in runs.items()})
    has_value = {metric.name: "alone" in metric.shown for metric in BOARD_METRICS[protocol]}
    found = {name: MetricValue(why=values.ALL_OPEN if has else ONLY_FINAL) for name, has in has_value.items()}
    if all(scores):
        score = statistics.mean_of_groups([statistics.mean_of_groups(list(part.values())) for part in scores])
        errors: dict[str, float] = defaultdict(float)
        for part in scores:
            for task, each in part.items():
                errors[task] += each.mean / len(part) / len(scores) * references.tasks[task].expert_error[0]
        terms = values.error_terms(errors.values(), [references.tasks[task].expert_error for task in errors])
        value = MetricValue.of(statistics.to_interval(score, terms))
        found |= {name: value for name, has in has_value.items() if has}
    return found

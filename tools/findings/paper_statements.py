"""Further statements of the 2017 paper: what its own printed tables say of each, and what runs here say.

Ours are runs of ``trpo`` with 300,000 steps per task, in scores, with 95 % intervals over runs, where not
stated otherwise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from statistics import fmean

import pandas as pd

from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.variations import Gravity
from gym_extensions.metrics.statistics import difference, interval, standard_deviation
from gym_extensions.scoring.group_score import GroupScore, PaperRow
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site.text import fixed, interval as interval_text
from tools.findings.tables import FINAL, LEARNED, LOST, Value

TRANSFER = ("walker2d-gravity", "halfcheetah-gravity", "walker2d-body", "halfcheetah-body")
NAVIGATION = ("nav-state", "nav-range")
SINGLE = "single_task_performance"
GRAVITY = 9.81
"""Of MuJoCo's default, in m/s²."""


@dataclass(frozen=True)
class PaperStatement:
    """A statement of the paper, a verdict from its own tables with the numbers, and the same from ours."""

    text: str
    printed: str
    here: str


def log_of(card: Scorecard, name: str, protocol: str = "sequential") -> GroupScore:
    """The scores of a submission on a group."""
    return card.groups[GROUPS[name].id][protocol]


def finals(rows: Sequence[PaperRow]) -> list[float]:
    """The returns at the end, of the tasks in training order."""
    return [row.fully_trained.mean for row in rows if row.fully_trained]


def rises(values: Sequence[float]) -> bool:
    """Whether each value is above the one before: performance declines going back in time."""
    return all(first < second for first, second in pairwise(values))


def falling(values: Sequence[float]) -> str:
    """The values from the last task back, with the relation of each pair."""
    parts = [fixed(values[-1], 0)]
    for later, earlier in pairwise(reversed(values)):
        parts += [">" if later > earlier else "<", fixed(earlier, 0)]
    return " ".join(parts)


def steps(ends: Sequence[Sequence[float]]) -> list[Value]:
    """The value of each task minus that of the task before, over runs, from the values by run and task."""
    return [Value.of(interval([run[at + 1] - run[at] for run in ends])) for at in range(len(ends[0]) - 1)]


def in_returns(value: Value) -> str:
    """A value in returns, without decimals."""
    return f"{fixed(value.mean, 0)} ({interval_text(value.low, value.high, 0)})"


def decline(printed: Scorecard, repeated: Scorecard, tuned: Scorecard) -> PaperStatement:
    """That the return of Hopper at the end falls the further one goes back in its sequence."""
    gravity, body = (finals(log_of(printed, f"hopper-{kind}").paper_table) for kind in ("gravity", "body"))
    total = log_of(printed, "hopper-gravity").printed_total
    assert total is not None and total.fully_trained is not None
    implied = total.fully_trained.mean * len(gravity) - sum(gravity[1:])
    repaired, ours = [implied, *gravity[1:]], finals(log_of(repeated, "hopper-gravity").paper_table)
    log = log_of(tuned, "hopper-body")
    rising = steps([run[-1] for run in log.return_matrix])
    at, lowest = min(enumerate(rising, 1), key=lambda step: step[1].high)
    return PaperStatement(
        "Hopper: performance decreases monotonically going back in the sequence",
        f"gravity: {verdict(rises(gravity))} as printed ({falling(gravity)}), "
        f"{verdict(rises(repaired))} with the cell that the total implies ({falling(repaired)}); "
        f"body parts: {verdict(rises(body))} ({falling(body)})",
        f"gravity, one run at the paper's budget: {verdict(rises(ours))} ({falling(ours)}); "
        f"body parts, means of {len(log.runs)} runs: {found(*rising)} ({falling(finals(log.paper_table))}); "
        f"the lowest step is {in_returns(lowest)}, task {at + 1} minus task {at}, "
        f"and forgetting {Value.of(log.metrics[LOST])}",
    )


def transfer(printed: Scorecard, tuned: Scorecard) -> PaperStatement:
    """That the final policy is better than those right after training and of single tasks."""
    own, here = [], []
    for name in TRANSFER:
        total = log_of(printed, name).printed_total
        assert total is not None and total.fully_trained and total.after_env_training
        end, after = total.fully_trained.mean, total.after_env_training.mean
        more = f", Single Env {fixed(total.single_env.mean, 0)}" if total.single_env else ""
        better = end > after and (total.single_env is None or end > total.single_env.mean)
        relation = ">" if end > after else "<"
        own.append(f"{name}: {verdict(better)} ({fixed(end, 0)} {relation} {fixed(after, 0)}{more})")
        log, single = log_of(tuned, name), log_of(tuned, name, "single")
        gain = zip(log.metrics[FINAL].runs, log.metrics[LEARNED].runs, strict=True)
        gap = Value.of(interval([end - after for end, after in gain]))
        over = Value.of(difference(log.metrics[FINAL].runs, single.metrics[SINGLE].runs))
        here.append(f"{name}: {found(gap, over)}, {gap} over After Env, {over} over Single Env")
    return PaperStatement(
        "Walker2d and HalfCheetah: the final policy beats those right after training and of single tasks",
        "; ".join(own),
        "; ".join(here),
    )


def spread(printed: Scorecard, episodes: pd.DataFrame) -> PaperStatement:
    """That the final policy has the higher variance, for example on Walker2d."""
    own, here = [], []
    for name in ("walker2d-gravity", "walker2d-body"):
        rows = log_of(printed, name).paper_table
        end, after = (
            fmean(cell.std for row in rows if (cell := row.cell(column)))
            for column in ("fully_trained", "after_env_training")
        )
        own.append(
            f"{name}: {verdict(end > after)}, mean deviation {fixed(end, 0)} against {fixed(after, 0)}"
        )
        tasks, frame = GROUPS[name].task_ids, episodes[episodes["group"] == GROUPS[name].id]
        cells = frame.groupby(["run", "stage", "task"])["return"]
        deviations = cells.agg(lambda returns: standard_deviation(list(returns)))
        gaps = []
        for run in sorted(set(frame["run"])):
            changes = [
                deviations[run, len(tasks), task] - deviations[run, stage, task]
                for stage, task in enumerate(tasks, 1)
            ]
            gaps.append(fmean(changes))
        gap = Value.of(interval(gaps))
        here.append(f"{name}: {found(gap)}, {in_returns(gap)} in returns")
    return PaperStatement(
        "The final policy has a higher variance, for example on Walker2d",
        "its totals mix two rules (pooled for Fully Trained, means of deviations for the other columns); "
        f"by one rule, {'; '.join(own)}",
        f"mean deviation at the end minus right after training: {'; '.join(here)}",
    )


def navigation(tuned: Scorecard) -> PaperStatement:
    """That TRPO does not learn to navigate: it does if its score right after training is above the floor.

    An untrained policy collides, so its score is far below the floor. Training ends the collisions, which
    does not lead to the goal.
    """
    parts, scores = [], []
    for name in NAVIGATION:
        log = log_of(tuned, name)
        scores.append(Value.of(log.metrics[LEARNED]))
        rates = [rate for run in log.success_rates for rate in run[-1] if rate is not None]
        success = f", {fixed(100 * fmean(rates), 0)} % of the last episodes reach the goal" if rates else ""
        parts.append(f"{name}: {scores[-1]} right after training, where 0 is the floor{success}")
    return PaperStatement(
        "Navigation: TRPO makes no progress",
        "no table is printed",
        f"{verdict(not any(score.high > 0 for score in scores))}: {'; '.join(parts)}",
    )


def gravities() -> PaperStatement:
    """The range of gravities that the text states."""
    tasks = GROUPS["hopper-gravity"].tasks
    factors = [each.factor for task in tasks for each in task.variations if isinstance(each, Gravity)]
    second, strongest = sorted(factors)[-2:]
    return PaperStatement(
        "Gravities from −4.91 to −12.26 m/s²",
        f"fails: its tables have tasks at {fixed(strongest, 1)} g",
        f"{fixed(second, 2)} g is −{fixed(second * GRAVITY, 2)} m/s²; "
        f"{fixed(strongest, 1)} g is −{fixed(strongest * GRAVITY, 2)} m/s²",
    )


def verdict(holds: bool) -> str:
    """Whether a statement about single numbers holds."""
    return "holds" if holds else "fails"


def found(*gaps: Value) -> str:
    """Whether a statement holds that all of these differences are above 0, by their intervals."""
    if all(gap.low > 0 for gap in gaps):
        return "holds"
    return "fails" if any(gap.high < 0 for gap in gaps) else "not found"


def statements(
    printed: Scorecard, repeated: Scorecard, tuned: Scorecard, episodes: pd.DataFrame
) -> list[PaperStatement]:
    """The five of them.

    Args:
        printed: the paper's tables.
        repeated: the repetition at the paper's budget.
        tuned: ``trpo``.
        episodes: of the sequential runs of ``trpo``, from ``results.episodes``.
    """
    return [
        decline(printed, repeated, tuned),
        transfer(printed, tuned),
        spread(printed, episodes),
        navigation(tuned),
        gravities(),
    ]

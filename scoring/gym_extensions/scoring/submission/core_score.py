"""The core score of a submission: its mean over the groups of the core, over runs that a look prescribes.

See docs/metrics.md, "The core". A look is an interim analysis, as in a clinical trial: submissions are
compared when they have 5, 10, 20, 40 or 80 runs, and every look has an error rate of its own, so that all
looks together keep 5 %. It uses exactly the runs 0 to n − 1 of every group, so that neither the number of
runs nor their choice can depend on their results.
"""

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from statistics import fmean

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.groups import CORE, CORES
from gym_extensions.catalog.protocol import PROTOCOLS, STANDARD_BUDGET
from gym_extensions.metrics.formulas import BY_NAME, CORE_METRICS, FINAL, Metric
from gym_extensions.metrics.statistics import (
    Summary,
    mean_of_groups,
    ratio_of_groups,
    summary,
    to_interval,
    zero_mean_p,
)
from gym_extensions.metrics.values import Estimate, MetricValue
from gym_extensions.scoring import scorecard
from gym_extensions.scoring.group_score import GroupScore, RunProvenance
from gym_extensions.scoring.submission.suites import suite_expert_errors
from gym_extensions.submissions.review import TRAINED_HERE
from gym_extensions.submissions.run import consecutive

LOOK_LEVELS = {5: 0.005, 10: 0.01, 20: 0.01, 40: 0.01, 80: 0.01}
"""The level of a family of pairs at each look: together the error is at most .05.

tools/benchmarks/measure_looks.py simulates it (docs/metrics.md). The sum for normal runs is below .05; the
rest is a reserve for the skewed and bimodal runs that submissions have, of which few show too small a
variance.
"""
LOOKS = tuple(LOOK_LEVELS)
"""Numbers of runs at which submissions are compared."""


def last_look(runs: int) -> int:
    """The last look with at most this number of runs; 0 if there is none."""
    return max((look for look in LOOKS if look <= runs), default=0)


def next_look(look: int) -> int | None:
    """The look after this one; None after the last."""
    return next((each for each in LOOKS if each > look), None)


def is_trained_here(card: scorecard.Scorecard) -> bool:
    """Whether the project trained the code of a submission often enough for the first look."""
    found = [log for log in core_logs(card).values() if log.level == TRAINED_HERE]
    return len(found) == len(CORES[CORE]) and all(len(log.runs) >= LOOKS[0] for log in found)


def core_logs(card: scorecard.Scorecard, protocol: str = "sequential") -> dict[str, GroupScore]:
    """The scores of a submission's runs with the core's budget on its groups, by group id, in its order."""
    return _on_core({name: card.log(name, protocol) for name in CORES[CORE]})


def _on_core(logs: Mapping[str, GroupScore | None]) -> dict[str, GroupScore]:
    found = {name: log for name in CORES[CORE] if (log := logs.get(name))}
    return {name: log for name, log in found.items() if log.runs and log.budget == STANDARD_BUDGET}


LEAST_DEVIATION, CLAIM_LEVEL = 0.08, 0.005
"""Of the test of an author's claim: the least standard deviation in a group, and the level."""


def claim(card: scorecard.Scorecard) -> scorecard.Claim | None:
    """The author's own runs on the core against those that were trained here, if there are both."""
    both = _on_core(card.own), core_logs(card)
    own, trained = ([log.metrics[FINAL.name].runs for log in logs.values()] for logs in both)
    if not is_trained_here(card) or len(own) < len(trained) or min(map(len, own + trained)) < 2:
        return None
    return claim_of(zip(own, trained, strict=True))


def claim_of(groups: Iterable[tuple[Sequence[float], Sequence[float]]]) -> scorecard.Claim:
    """The test of a claim: by group, the values of the author's runs and of those that were trained here.

    It is about the mean over groups of the differences. The variance of a group is pooled over both samples,
    and at least that of ``LEAST_DEVIATION``: chosen and copied runs vary little. Satterthwaite's degrees of
    freedom, one-sided.
    """
    differences = []
    for own, trained in groups:
        first, second = summary(own), summary(trained)
        sums = (each.squared_error * each.runs * (each.runs - 1) for each in (first, second))
        df = first.runs + second.runs - 2
        variance = max(sum(sums) / df, LEAST_DEVIATION**2)
        error = variance * (1 / first.runs + 1 / second.runs)
        differences.append(Summary(first.mean - second.mean, error, df, min(first.runs, second.runs)))
    found = mean_of_groups(differences)
    p_value = zero_mean_p(found) / 2
    p_value = p_value if found.mean > 0 else 1 - p_value
    return scorecard.Claim(found.mean, p_value, p_value > CLAIM_LEVEL)


def verified_runs(log: GroupScore) -> int:
    """The number N of runs 0 to N − 1 that are all verified."""
    return consecutive([run for run in log.runs if run not in log.unverified])


def counted_runs(log: GroupScore) -> int:
    """The number N of runs 0 to N − 1 that may be compared. Later ones wait until they are verified.

    A submission that has verified too few for the first look has no rank, and shows all of its runs.
    """
    verified = verified_runs(log)
    return verified if verified >= LOOKS[0] else consecutive(log.runs)


def on_group(log: GroupScore, look: int, metric: Metric = FINAL) -> scorecard.CoreGroup:
    """A metric on one group over the runs of a look; over all that may be compared if that is 0."""
    runs = look or counted_runs(log)
    values = log.metrics[metric.name].runs[:runs]
    if not values:
        return scorecard.CoreGroup(runs=runs)
    value = to_interval(summary(values), suite_expert_errors([log], metric))
    others = {
        name: fmean(found[:runs])
        for name in CORE_METRICS
        if name != metric.name and name in log.metrics and (found := log.metrics[name].runs)
    }
    return scorecard.CoreGroup(value.mean, value.low, value.high, len(values), others)


def mean_over_groups(logs: Iterable[GroupScore], metric: str, runs: int) -> Summary:
    """The mean over groups of the first runs of each, with its error over runs."""
    return mean_of_groups([summary(log.metrics[metric].runs[:runs]) for log in logs])


def over_groups(logs: Collection[GroupScore], metric: Metric, runs: int) -> MetricValue:
    """The mean over groups of the first runs of each, with the errors of the experts."""
    mean = mean_over_groups(logs, metric.name, runs)
    return MetricValue.of(to_interval(mean, suite_expert_errors(logs, metric)))


def final_scores(logs: Collection[GroupScore], runs: int) -> list[NDArray[np.float64]]:
    """The scores at the end of the first runs of each group, (runs, tasks), without open tasks."""
    scored = ([log.scores(at) for at in range(len(log.tasks))] for log in logs)
    return [np.array([[run[-1] for run in task[:runs]] for task in tasks if task]).T for tasks in scored]


def retention(logs: Collection[GroupScore], runs: int) -> Estimate:
    """The score that is left of all tasks but the last, as a share of their score right after training.

    Both are means over tasks, then over groups, of the first runs. Empty if these tasks were not learned: the
    interval of their score right after training is not above 0.
    """
    pairs = []
    for log in logs:
        scores = {at + 1: scores for at in range(len(log.tasks) - 1) if (scores := log.scores(at))}
        left = [fmean(task[run][-1] for task in scores.values()) for run in range(runs)]
        learned = [fmean(task[run][stage] for stage, task in scores.items()) for run in range(runs)]
        pairs.append((left, learned))
    if (to_interval(mean_of_groups([summary(learned) for _, learned in pairs])).low or 0.0) <= 0:
        return Estimate()
    ratio = ratio_of_groups(pairs)
    return Estimate(ratio.mean, ratio.low, ratio.high)


def core_score(card: scorecard.Scorecard) -> scorecard.CoreScore | None:
    """The core score of a submission; None if it is withdrawn, or has no runs on the core with its budget."""
    logs = core_logs(card)
    if card.withdrawn or not logs:
        return None
    missing = tuple(name for name in CORES[CORE] if name not in logs)
    without = [
        f"No score in {name}: {value.why}"
        for name, log in logs.items()
        for value in (log.metrics[metric] for metric in CORE_METRICS)
        if not value.runs
    ]
    look = 0 if missing or without else last_look(min(map(counted_runs, logs.values())))
    assert card.manifest is not None, "it has runs"
    protocol, why = card.manifest.protocol, _why(logs, missing, without)
    metrics = dict.fromkeys(CORE_METRICS, MetricValue(why=why))
    if look:
        metrics = {name: over_groups(logs.values(), BY_NAME[name], look) for name in CORE_METRICS}
    core = scorecard.CoreScore(
        why=why,
        parent=protocol.parent or protocol.algorithm,
        look=look,
        next_look=next_look(look),
        missing=missing,
        metrics=metrics,
        retention=retention(logs.values(), look) if look else Estimate(),
        groups={name: on_group(log, look) for name, log in logs.items()},
        trained_here=is_trained_here(card),
        claim=claim(card),
        cost=_cost(logs),
    )
    return replace(core, notes=tuple(_notes(card, logs, core)))


def _why(logs: Mapping[str, GroupScore], missing: Sequence[str], without: Sequence[str]) -> str:
    """Why a submission has no rank on the core; empty if it has one."""
    for log in logs.values():
        if verified_runs(log) < min(LOOKS[0], consecutive(log.runs)):
            return f"Claimed: {log.why_claimed or 'not verified.'}"
    if missing:
        return f"It lacks {', '.join(missing)}."
    if without:
        return without[0]
    few = [name for name, log in logs.items() if counted_runs(log) < LOOKS[0]]
    return f"Fewer than {LOOKS[0]} runs in {', '.join(few)}." if few else ""


def _notes(
    card: scorecard.Scorecard, logs: Mapping[str, GroupScore], core: scorecard.CoreScore
) -> Iterator[str]:
    """What is not compared, and what to know of runs that were trained here, with the name of the case."""
    counts, look = {name: counted_runs(log) for name, log in logs.items()}, core.look
    if core.missing:
        yield f"partial-core: It has no sequential runs of {', '.join(core.missing)}."
    if len(set(counts.values())) > 1:
        parts = ", ".join(f"{name} {count}" for name, count in counts.items())
        yield f"different-numbers-of-runs: The groups have {parts} runs."
    if beyond := {name: range(look, count) for name, count in counts.items() if count > look > 0}:
        until = f"Waiting until every group has {core.next_look} runs" if core.next_look else "Not compared"
        yield f"runs-beyond-the-look: Compared: runs 0 to {look - 1}. {until}: {_runs_by_group(beyond)}."
    if not (card.steps_counted or core.trained_here):
        yield "steps-claimed: Its training steps are claimed; its page says where its policies are from."
    waiting = {name: sorted(log.unverified) for name, log in logs.items() if log.unverified}
    if waiting and look:
        yield f"unverified-runs: Not compared until they are verified: {_runs_by_group(waiting)}."
    if core.claim:
        says = "agree with these" if core.claim.agrees else f"claim {core.claim.difference:.2f} more"
        yield f"claim: The author's own runs {says}."
    if card.training and card.training.attempts > 1:
        yield f"attempts: {card.training.attempts} versions of its code were trained; this is the last."
    if card.training and (failed := sum("/sequential/" in key for key in card.training.failed)):
        yield f"failed-runs: Runs that failed, and count as the floor: {failed}."
    if card.training and card.training.outdated:
        yield "outdated: Its code was changed since, and waits to be trained."


def _runs_by_group(found: Mapping[str, Sequence[int]]) -> str:
    """Ascending runs with their groups, for example ``runs 5 to 7 of hopper-wall-v0``."""
    names: dict[str, list[str]] = {}
    for name, runs in found.items():
        is_range = 1 < len(runs) == runs[-1] - runs[0] + 1
        numbers = f"{runs[0]} to {runs[-1]}" if is_range else ", ".join(map(str, runs))
        names.setdefault(f"run{'s' * (len(runs) > 1)} {numbers}", []).append(name)
    return "; ".join(f"{runs} of {', '.join(groups)}" for runs, groups in names.items())


def _cost(logs: Mapping[str, GroupScore]) -> scorecard.CoreCost:
    """The cost of a run. Some runs state the largest memory of all groups; a group's least is its own."""
    documents = [log.provenance for log in logs.values()]
    total = _total(documents)
    is_whole, is_timed = (number == len(CORES[CORE]) for number in (total.groups, total.timed_groups))
    peaks = [[run.peak_memory_mb for run in runs if run.peak_memory_mb is not None] for runs in documents]
    return scorecard.CoreCost(
        steps=total.steps if is_whole else None,
        cpu_seconds=total.cpu_seconds if is_timed else None,
        peak_memory_mb=max(map(max, peaks)) if all(peaks) else None,
        stored_steps=max(min(run.memory.stored_steps for run in runs) for runs in documents),
        parameters=max(min(run.memory.parameters_last for run in runs) for runs in documents),
    )


def run_cost(card: scorecard.Scorecard) -> scorecard.RunCost | None:
    """What a run takes of those that the core compares, else of all; None where no run is documented."""
    logs = core_logs(card)
    if card.core is None:
        used = {protocol for each in card.groups.values() for protocol in each}
        protocol = min(used, key=PROTOCOLS.index, default="")
        logs = {name: log for name, each in card.groups.items() if (log := each.get(protocol))}
    found = [log.provenance for log in logs.values() if log.provenance]
    return _total(found) if found else None


def _total(groups: Sequence[Sequence[RunProvenance]]) -> scorecard.RunCost:
    times = [[run.cpu_seconds for run in runs if run.cpu_seconds is not None] for runs in groups]
    timed = [seconds for seconds in times if seconds]
    numbers = [len(seconds) for seconds in timed]
    return scorecard.RunCost(
        steps=sum(fmean(run.steps for run in runs) for runs in groups),
        groups=len(groups),
        cpu_seconds=math.fsum(map(fmean, timed)),
        timed_groups=len(timed),
        timed_runs=(min(numbers, default=0), max(numbers, default=0)),
    )

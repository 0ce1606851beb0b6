"""Every metric of one group and protocol, with its interval over runs, or with why there is none."""

from __future__ import annotations

from dataclasses import dataclass

from gym_extensions.scoring.metrics.definitions import FINAL, METRICS, Metric
from gym_extensions.scoring.metrics.normalization import normalised
from gym_extensions.scoring.metrics.returns import Results
from gym_extensions.scoring.metrics.run import Run
from gym_extensions.scoring.references import References
from gym_extensions.scoring.statistics.intervals import Interval, difference, interval

ONE_RUN = "One run has no interval."
ALL_OPEN = "Every task of this group is open: no reference agent has learned it."
NO_TERM = "No task that is not open meets the formula's condition on j."
TOO_FEW_POINTS = "A training curve that it needs is missing from curves.csv or has fewer than 10 points."


@dataclass(frozen=True)
class Score:
    """A metric's value on a group: mean over runs and interval, one value a run, and why one is missing."""

    interval: Interval | None
    runs: tuple[float, ...] = ()
    why: str = ""

    def as_dict(self) -> dict[str, object]:
        """Mean, low, high, runs, and ``why`` where the mean or the interval is null."""
        found = self.interval
        document: dict[str, object] = {
            "mean": found.mean if found else None,
            "low": found.low if found else None,
            "high": found.high if found else None,
            "runs": list(self.runs),
        }
        return document | ({"why": self.why} if self.why else {})


def _lacking(metric: Metric, results: Results) -> str:
    there = {name for name in results.runs if getattr(results, name) is not None}
    there |= {"curves"} if results.curves else set()
    missing = [f"{name}.csv" for name in metric.needs if name not in there]
    return f"It needs {' and '.join(missing)}, which this entry lacks." if missing else ""


def _score(metric: Metric, runs: list[Run]) -> Score:
    values: list[float] = []
    for run in runs:
        try:
            value = metric.function(run) if metric.function else None
        except KeyError:
            return Score(None, why=TOO_FEW_POINTS)
        if value is None:
            return Score(None, why=ALL_OPEN if not run.scored else NO_TERM)
        values.append(value)
    return Score(interval(values), tuple(values), ONE_RUN if len(values) == 1 else "")


def _joint_gap(final: Score, joint: Score) -> Score:
    """Joint final performance less the sequential one; runs are not paired, so Welch's interval."""
    if not final.runs or not joint.runs:
        return Score(None, why=final.why or joint.why)
    gap = difference(joint.runs, final.runs)
    return Score(gap, why=ONE_RUN if gap.low is None else "")


def no_reference(results: Results, references: References) -> str:
    """Why a group cannot be normalised, or nothing: some of its tasks have no reference."""
    lacking = references.lacking(results.group.task_ids)
    if not lacking:
        return ""
    share = f"{len(lacking)} of {len(results.group.tasks)} tasks"
    return f"Benchmark version {references.version!r} has no reference for {share}, {lacking[0]} among them."


def scores(results: Results, references: References, protocol: str, runs: list[Run]) -> dict[str, Score]:
    """The score of every metric of a protocol, by its name, in the order of the metrics' table.

    ``runs`` are the protocol's normalised runs, none where a task of the group has no reference.
    """
    unknown = no_reference(results, references)
    found: dict[str, Score] = {}
    for metric in METRICS[protocol]:
        here = metric.needs if protocol == "sequential" else (protocol,)
        why = unknown or _lacking(metric, results) if here == metric.needs else unknown
        if why:
            found[metric.name] = Score(None, why=why)
        elif metric.function is None:
            joint = _score(FINAL, normalised(results, references, "joint"))
            found[metric.name] = _joint_gap(found[FINAL.name], joint)
        else:
            found[metric.name] = _score(metric, runs)
    return found

"""A task's row of the references file, computed from the returns of its reference episodes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from gym_extensions.catalog.protocol import FIRST_REFERENCE_RUN, FULL_ENTRY_RUNS

MIN_ERRORS, MIN_DEVIATIONS = 5.0, 1.0
"""A run beats the floor by at least this many standard errors and standard deviations."""
MIN_RUNS = 3
"""Of five or more runs, at least this many must beat the floor."""


def summary(returns: Sequence[float]) -> dict[str, float]:
    """Mean, population standard deviation and standard error of the mean of episode returns."""
    mean = math.fsum(returns) / len(returns)
    std = math.sqrt(math.fsum((value - mean) ** 2 for value in returns) / len(returns))
    return {"mean": mean, "std": std, "standard_error": std / math.sqrt(len(returns))}


def beats_floor(run: Mapping[str, float], floor: Mapping[str, float]) -> bool:
    """Whether a run is above the floor by five standard errors and one standard deviation of its episodes."""
    difference = run["mean"] - floor["mean"]
    error = math.hypot(run["standard_error"], floor["standard_error"])
    clear = difference >= MIN_ERRORS * error and difference >= MIN_DEVIATIONS * run["std"]
    return clear and difference > 0


def is_unsolved(beaten: Sequence[bool]) -> bool:
    """Whether a task is unsolved: fewer than three runs beat the floor, or, of under five runs, not all."""
    if len(beaten) < FULL_ENTRY_RUNS:
        return not all(beaten)
    return sum(beaten) < MIN_RUNS


def floor_row(
    returns: Mapping[str, Sequence[float]],
    seeds: Mapping[str, int],
    *,
    fingerprint: str,
    log_sha256: str,
) -> dict[str, Any]:
    """The floor of one task: the mean return of its better floor agent, and the summaries of both.

    Args:
        returns: of each agent's episodes.
        seeds: of each agent.
        fingerprint: of the task.
        log_sha256: of the log with every episode of both agents.
    """
    agents = {name: summary(values) | {"seed": seeds[name]} for name, values in returns.items()}
    better = max(agents, key=lambda name: agents[name]["mean"])
    return {
        "mean": agents[better]["mean"],
        "agent": better,
        "budget": None,
        "run": FIRST_REFERENCE_RUN,
        "episodes": len(returns[better]),
        "standard_error": agents[better]["standard_error"],
        "agents": agents,
        "fingerprint": fingerprint,
        "log_sha256": log_sha256,
    }


def task_row(
    floor: Mapping[str, Any],
    runs: Mapping[int, Sequence[float]],
    *,
    agent: str,
    budget: str,
    log_sha256: str,
) -> dict[str, Any]:
    """The references of one task, from its floor and the returns of its reference runs."""
    summaries = {run: summary(returns) for run, returns in sorted(runs.items())}
    rows: list[dict[str, Any]] = [
        {"run": run, "mean": row["mean"], "std": row["std"], "beats_floor": beats_floor(row, floor)}
        for run, row in summaries.items()
    ]
    mean, error = _over_runs(list(summaries.values()))
    ceiling = {
        "mean": mean,
        "agent": agent,
        "budget": budget,
        "episodes": len(next(iter(runs.values()))),
        "standard_error": error,
        "runs": rows,
        "log_sha256": log_sha256,
    }
    unsolved = is_unsolved([row["beats_floor"] for row in rows])
    row = {"floor": dict(floor), "ceiling": None if unsolved else ceiling, "unsolved": unsolved}
    return row | ({"attempts": ceiling} if unsolved else {})


def _over_runs(summaries: Sequence[Mapping[str, float]]) -> tuple[float, float]:
    """The mean over runs and its standard error; of a single run, the error over its episodes."""
    means = [summary["mean"] for summary in summaries]
    mean = math.fsum(means) / len(means)
    if len(means) == 1:
        return mean, summaries[0]["standard_error"]
    deviation = math.sqrt(math.fsum((value - mean) ** 2 for value in means) / (len(means) - 1))
    return mean, deviation / math.sqrt(len(means))

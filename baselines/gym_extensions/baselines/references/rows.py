"""From the returns of reference episodes to a task's row of the references file."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from gym_extensions.catalog.protocol import FIRST_REFERENCE_RUN, FULL_ENTRY_RUNS

CLEAR_ERRORS, CLEAR_DEVIATIONS, CLEAR_RUNS = 5.0, 1.0, 3
"""A run beats the floor by so many standard errors and deviations; so many runs of five or more must."""


def summary(returns: Sequence[float]) -> dict[str, float]:
    """Mean, population standard deviation and standard error of the mean of episode returns."""
    mean = math.fsum(returns) / len(returns)
    std = math.sqrt(math.fsum((value - mean) ** 2 for value in returns) / len(returns))
    return {"mean": mean, "std": std, "standard_error": std / math.sqrt(len(returns))}


def beats_floor(run: Mapping[str, float], floor: Mapping[str, float]) -> bool:
    """Whether a run is above the floor by five standard errors and by one deviation of its own episodes."""
    above = run["mean"] - floor["mean"]
    error = math.hypot(run["standard_error"], floor["standard_error"])
    return above >= CLEAR_ERRORS * error and above >= CLEAR_DEVIATIONS * run["std"] and above > 0


def is_open(beaten: Sequence[bool]) -> bool:
    """Whether nobody has learned the task: fewer than three runs did, or, of under five, not all."""
    if len(beaten) < FULL_ENTRY_RUNS:
        return not all(beaten)
    return sum(beaten) < CLEAR_RUNS


def floor_row(
    returns: Mapping[str, Sequence[float]],
    seeds: Mapping[str, int],
    *,
    fingerprint: str,
    log_sha256: str,
) -> dict[str, Any]:
    """The floor of one task: the better of the blind agents, and what each of them got.

    Args:
        returns: of each agent's episodes.
        seeds: what each agent's generator was seeded with.
        fingerprint: of the task that was measured.
        log_sha256: of the log that holds every episode of every agent.
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
    """The references of one task, from its floor and from the returns of the reference runs."""
    found = {run: summary(returns) for run, returns in sorted(runs.items())}
    rows: list[dict[str, Any]] = [
        {"run": run, "mean": own["mean"], "std": own["std"], "beats_floor": beats_floor(own, floor)}
        for run, own in found.items()
    ]
    mean, error = _over_runs(list(found.values()))
    ceiling = {
        "mean": mean,
        "agent": agent,
        "budget": budget,
        "episodes": len(next(iter(runs.values()))),
        "standard_error": error,
        "runs": rows,
        "log_sha256": log_sha256,
    }
    open_ = is_open([row["beats_floor"] for row in rows])
    row = {"floor": dict(floor), "ceiling": None if open_ else ceiling, "unsolved": open_}
    return row | ({"attempts": ceiling} if open_ else {})


def _over_runs(found: Sequence[Mapping[str, float]]) -> tuple[float, float]:
    """The mean of the runs' means and its standard error; of one run, the error over its episodes."""
    means = [own["mean"] for own in found]
    mean = math.fsum(means) / len(means)
    if len(means) == 1:
        return mean, found[0]["standard_error"]
    spread = math.sqrt(math.fsum((value - mean) ** 2 for value in means) / (len(means) - 1))
    return mean, spread / math.sqrt(len(means))

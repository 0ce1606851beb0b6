"""Rules that compare the logs of a group."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

from gym_extensions.rollouts.identical_runs import first_identical_runs
from gym_extensions.rollouts.layout import MAX_RUNS
from gym_extensions.rollouts.problem import Finding, quote
from gym_extensions.rollouts.reading.evaluation_log import Log, Runs
from gym_extensions.rollouts.rules.rule import rule

PARTNER = {"sequential": "single", "single": "sequential"}
"""The log that has the other run of a pair."""


@dataclass(frozen=True)
class GroupLogs:
    """The readable rows of a group's logs by protocol.

    ``runs`` are the runs of each log, None where they are unknown; ``is_trainable`` is whether the agent has
    parameters to train, None if unknown.
    """

    name: str
    logs: dict[str, Log]
    runs: Runs
    is_trainable: bool | None


@rule("runs")
def too_many_runs(log: Log) -> Iterator[Finding]:
    """A log has at most 100 runs."""
    if len(log.runs) > MAX_RUNS:
        message = f"The log has {len(log.runs)} runs; the limit is {MAX_RUNS}."
        yield Finding(log.path, message, f"Submit the runs 0 to {MAX_RUNS - 1}.")


@rule("group")
def different_runs(group: GroupLogs) -> Iterator[Finding]:
    """sequential.csv and single.csv have the same runs: forward transfer pairs them by training seed."""
    sequential, single = group.runs.get("sequential"), group.runs.get("single")
    if sequential is None or single is None or sequential == single:
        return
    message = f"The runs are {quote(list(single))}; sequential.csv has {quote(list(sequential))}."
    hint = "Add the missing runs to either file, or leave them out of both."
    yield Finding(f"{group.name}/single.csv", message, hint)


@rule("group")
def gaps_in_runs(group: GroupLogs) -> Iterator[Finding]:
    """The runs of a log are 0 to N − 1 without gaps, so that no runs can be selected by their results."""
    for protocol, runs in group.runs.items():
        if runs and list(runs) != list(range(len(runs))):
            candidates = (run for run in itertools.count() if run not in runs)
            missing = list(itertools.islice(candidates, max(0, min(MAX_RUNS, max(runs) + 1 - len(runs)))))
            message = (
                f"The runs are {quote(list(runs))}; of 0 to {max(runs)}, these are missing: {quote(missing)}."
            )
            hint = "Train the missing runs; no run may be left out."
            yield Finding(f"{group.name}/{protocol}.csv", message, hint)


@rule("group")
def identical_runs(group: GroupLogs) -> Iterator[Finding]:
    """No two runs of a trainable agent are identical in every episode. (Runs of an agent without parameters
    may be, in both sequential.csv and single.csv: they count as one, and the scorecard says so.)"""
    first = {protocol: first_identical_runs(log) for protocol, log in group.logs.items()}
    for protocol, log in group.logs.items():
        partner = first.get(PARTNER.get(protocol, ""), {})
        for run, original in first[protocol].items():
            is_identical_pair = partner.get(run) == partner.get(original)
            if run == original or (is_identical_pair and not group.is_trainable):
                continue
            message = f"Run {run} is identical to run {original} in every episode."
            hint = "Train each run with its own seed; for an agent without parameters, say so in [memory]."
            if not (is_identical_pair or group.is_trainable):
                message += f" In {PARTNER[protocol]}.csv they differ."
                hint = "Train each run with its own seed, and write both files from the same agent."
            yield Finding(log.path, message, hint)

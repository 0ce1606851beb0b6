"""Rules about the logs of one group together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from gym_extensions.scoring.checks.rule import rule
from gym_extensions.scoring.problems import Finding
from gym_extensions.scoring.rows import Log, per_run


@dataclass(frozen=True)
class GroupLogs:
    """The complete logs of a group by protocol; ``learns`` is whether the agent has parameters to train."""

    name: str
    logs: dict[str, Log]
    learns: bool = True


@rule("group")
def different_runs(group: GroupLogs) -> Iterator[Finding]:
    """sequential.csv and single.csv have the same runs: forward transfer pairs them by training seed."""
    sequential, single = group.logs.get("sequential"), group.logs.get("single")
    if sequential is None or single is None or sequential.runs == single.runs:
        return
    found = f"The runs are {list(single.runs)}; sequential.csv has {list(sequential.runs)}."
    yield Finding(
        single.path, found, "Add the runs that are missing on either side, or leave them out on both."
    )


def outcomes(log: Log) -> list[tuple[bytes, bytes, bytes]]:
    """What each run of a complete log measured, as bytes: lengths, returns and ends."""
    size = per_run(log.protocol, log.group)
    return [
        tuple(column[start : start + size].tobytes() for column in (log.length, log.return_, log.terminated))  # type: ignore[misc]
        for start in range(0, len(log.task), size)
    ]


@rule("group")
def identical_runs(group: GroupLogs) -> Iterator[Finding]:
    """No two runs of a learning agent are the same in every episode: a copied run is no second measurement.

    (Runs of an agent without parameters may be: they count as one, and the scorecard says so.)
    """
    for log in group.logs.values() if group.learns else ():
        first: dict[tuple[bytes, bytes, bytes], int] = {}
        for run, outcome in zip(log.runs, outcomes(log), strict=True):
            if first.setdefault(outcome, run) != run:
                found = f"Run {run} is the same as run {first[outcome]} in every episode."
                hint = (
                    "Train each run with its own seed; an agent that has no parameters says so in [memory]."
                )
                yield Finding(log.path, found, hint)

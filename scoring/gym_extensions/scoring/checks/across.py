"""Rules about the logs of one group together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gym_extensions.scoring.checks.rule import rule
from gym_extensions.scoring.problems import Finding
from gym_extensions.scoring.rows import Log, Runs

PARTNER = {"sequential": "single", "single": "sequential"}
"""The log that a run of one agent is paired in."""


@dataclass(frozen=True)
class GroupLogs:
    """The logs of a group by protocol, as far as they can be read.

    ``runs`` are the runs of each, None where they cannot be known; ``learns`` is whether the agent has
    parameters to train, None likewise.
    """

    name: str
    logs: dict[str, Log]
    runs: Runs
    learns: bool | None


@rule("group")
def different_runs(group: GroupLogs) -> Iterator[Finding]:
    """sequential.csv and single.csv have the same runs: forward transfer pairs them by training seed."""
    sequential, single = group.runs.get("sequential"), group.runs.get("single")
    if sequential is None or single is None or sequential == single:
        return
    found = f"The runs are {list(single)}; sequential.csv has {list(sequential)}."
    hint = "Add the runs that are missing on either side, or leave them out on both."
    yield Finding(f"{group.name}/single.csv", found, hint)


def outcomes(log: Log) -> dict[int, tuple[bytes, ...]]:
    """What each run of a log measured, as bytes: episode by episode, whatever the order of the rows."""
    order = np.lexsort((log.episode, log.position, log.stage, log.run))
    starts = np.searchsorted(log.run[order], log.runs).tolist()
    ends = [*starts[1:], order.size]
    measured = (log.stage, log.position, log.episode, log.length, log.return_, log.terminated)
    columns = [column[order] for column in measured]
    return {
        run: tuple(column[start:end].tobytes() for column in columns)
        for run, start, end in zip(log.runs, starts, ends, strict=True)
    }


def originals(log: Log) -> dict[int, int]:
    """For each run of a log the first run that is the same in every episode, itself where none is before."""
    first: dict[tuple[bytes, ...], int] = {}
    return {run: first.setdefault(outcome, run) for run, outcome in outcomes(log).items()}


@rule("group")
def identical_runs(group: GroupLogs) -> Iterator[Finding]:
    """No two runs of a learning agent are the same in every episode: a copied run is no second measurement.

    (Runs of an agent without parameters may be, in sequential.csv and single.csv alike: they count as one,
    and the scorecard says so.)
    """
    same = {protocol: originals(log) for protocol, log in group.logs.items()}
    for protocol, log in group.logs.items():
        partner = same.get(PARTNER.get(protocol, ""), {})
        for run, first in same[protocol].items():
            alike = partner.get(run) == partner.get(first)
            if run == first or (alike and not group.learns):
                continue
            found = f"Run {run} is the same as run {first} in every episode."
            hint = "Train each run with its own seed; an agent that has no parameters says so in [memory]."
            if not (alike or group.learns):
                found += f" In {PARTNER[protocol]}.csv they differ."
                hint = "Train each run with its own seed, and write both files from the same agent."
            yield Finding(log.path, found, hint)

"""Rules about the logs of one group together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from gym_extensions.rollouts.identical_runs import originals
from gym_extensions.rollouts.problem import Finding
from gym_extensions.rollouts.reading.evaluation_log import Log, Runs
from gym_extensions.rollouts.rules.rule import rule

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

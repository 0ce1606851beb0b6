"""The commands that check an entry and repeat a run of it, and the paths of its logs."""

from __future__ import annotations

import shlex
from dataclasses import dataclass

from gym_extensions.scoring.scorecard.model import REPORTED, Scorecard
from gym_extensions.site.views.trial import group_trials

FOLDER = "submissions"


@dataclass(frozen=True)
class Commands:
    """The commands and log files of an entry, as text.

    Args:
        check: scores the entry and replays its recorded episodes.
        repeat: retrains the first run of the first group and compares it with the log.
        logs: the path of each log, relative to the repository.
    """

    check: str
    repeat: str
    logs: tuple[str, ...]


def commands(card: Scorecard) -> Commands | None:
    """The commands of an entry; None for a refused entry or a published table, which have no logs."""
    trials = [trial for trial in group_trials(card) if trial.runs]
    if card.problems or card.trust == REPORTED or not trials:
        return None
    folder = shlex.quote(f"{FOLDER}/{card.name}")
    first = trials[0]
    group = _name(first.group)
    return Commands(
        check=f"score {folder} --verify",
        repeat=f"gym-extensions reproduce {folder} --group {group} --protocol {first.protocol} "
        f"--run {first.runs[0]}",
        logs=tuple(f"{FOLDER}/{card.name}/{_name(trial.group)}/{trial.protocol}.csv" for trial in trials),
    )


def _name(group_id: str) -> str:
    return group_id.rpartition("-v")[0] or group_id

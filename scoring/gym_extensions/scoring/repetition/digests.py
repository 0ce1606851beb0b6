"""What a repetition of a run is about: its rows of the log and its policies."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass

from gym_extensions.rollouts.folder import Folder
from gym_extensions.rollouts.layout import POLICIES, policy_names
from gym_extensions.rollouts.reading.evaluation_log import Log
from gym_extensions.rollouts.submission import Submission
from gym_extensions.scoring.replay.policy_files import has_policies


@dataclass(frozen=True, order=True)
class RunKey:
    """A run of a log: group id, protocol and run."""

    group: str
    protocol: str
    run: int

    def __str__(self) -> str:
        return f"{self.group} {self.protocol} run {self.run}"


def run_digests(submission: Submission, folder: Folder) -> dict[RunKey, str]:
    """The digest of every run of a submission without problems; empty for a run without policies.

    It is the SHA-256 of one line per file: the SHA-256 of the run's rows, with their line ends, and those of
    its policies, sorted by name. Other runs and groups are not part of it, so that they can be added later.
    """
    logs = [log for group in submission.groups.values() for log in group.logs.values()]
    return {key: digest for log in logs for key, digest in _digests(log, folder)}


def _digests(log: Log, folder: Folder) -> Iterator[tuple[RunKey, str]]:
    is_complete = has_policies(log, folder)
    rows: dict[int, list[bytes]] = {run: [] for run in log.runs}
    for line in folder.read(log.path).splitlines(keepends=True)[1:]:
        rows[int(line.partition(b",")[0])].append(line)
    for run in log.runs:
        names = sorted(policy_names(log.protocol, [run], log.group))
        files = [b"".join(rows[run])]
        files += [folder.read(f"{log.group.name}/{POLICIES}/{name}") for name in names if is_complete]
        text = "".join(f"{hashlib.sha256(data).hexdigest()}\n" for data in files)
        digest = hashlib.sha256(text.encode()).hexdigest() if is_complete else ""
        yield RunKey(log.group.id, log.protocol, run), digest

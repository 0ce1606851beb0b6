"""The traces to which the logs of a submission commit: their Merkle root, and what a changed log needs."""

from __future__ import annotations

from pathlib import Path

from gym_extensions.baselines.submission.rows import read_episodes
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.auditing.digests import merkle_root
from gym_extensions.rollouts.layout import SALT_FILE, TRACES


def logs_of(*folders: Path) -> list[Path]:
    """The logs in the folders, by group and protocol; that of the first folder that has it."""
    names = {path.parent.name for folder in folders for path in folder.glob("*/*.csv")}
    paths = []
    for name in sorted(names):
        for protocol in PROTOCOLS:
            versions = (folder / name / f"{protocol}.csv" for folder in folders)
            paths += [path for path in versions if path.exists()][:1]
    return paths


def traces_root(*folders: Path) -> str:
    """The Merkle root of the traces of all logs in the folders; see :func:`logs_of`."""
    return merkle_root([row.trace for log in logs_of(*folders) for row in read_episodes(log)])


def require_bound(folder: Path) -> None:
    """Raises ``BenchError`` if a log of the submission commits to no traces."""
    for log in logs_of(folder):
        with log.open(encoding="utf-8") as file:
            header = file.readline()
        if "trace" not in header.rstrip().split(","):
            hint = "Record its runs again with this version, in another folder."
            raise BenchError("unbound-log", "The log has no column `trace`.", str(log), hint)


def require_unsalted(folder: Path, group_name: str) -> None:
    """Raises ``BenchError`` if a salt has drawn the traces of a group, so that its logs must not change."""
    path = folder / group_name / TRACES / SALT_FILE
    if path.exists():
        message = "A salt has drawn the traces of these logs; with another run they are other logs."
        hint = f"Run: gym-extensions trace {folder}, which removes the salt, and repeat the command."
        raise BenchError("salted-traces", message, str(path), hint)

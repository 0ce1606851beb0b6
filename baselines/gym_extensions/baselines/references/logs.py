"""The logs of a references file: every episode that a floor or a ceiling was computed from."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path

from gym_extensions.atomic import write_text
from gym_extensions.rollouts.episodes import Episode, write_episodes

FLOOR_COLUMNS = ("agent", "episode", "seed", "length", "return", "terminated")
"""The task and its fingerprint are in the references file."""


def write_ceiling_log(folder: Path, task_id: str, episodes: Sequence[Episode]) -> str:
    """Writes the episodes of a task's reference runs as a rollout log and returns the file's sha256."""
    path = folder / _file_name(task_id)
    write_episodes(path, episodes, (task_id,))
    return _sha256(path)


def write_floor_log(folder: Path, task_id: str, episodes: Mapping[str, Sequence[Episode]]) -> str:
    """Writes the episodes of a task's floor agents, agent by agent, and returns the file's sha256."""
    path = folder / "floors" / _file_name(task_id)
    lines = [",".join(FLOOR_COLUMNS)]
    for agent, rows in episodes.items():
        for row in sorted(rows, key=lambda row: row.episode):
            terminated = "true" if row.terminated else "false"
            lines.append(f"{agent},{row.episode},{row.seed},{row.length},{row.return_!r},{terminated}")
    write_text(path, "\n".join(lines) + "\n")
    return _sha256(path)


def _file_name(task_id: str) -> str:
    return f"{task_id.rpartition('/')[2]}.csv"


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()

"""The logs beside a references file: every episode that a floor or a ceiling was computed from."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path

from gym_extensions.atomic import write_text
from gym_extensions.rollouts.episodes import Episode, write_episodes

FLOOR_COLUMNS = ("agent", "episode", "seed", "length", "return", "terminated")
"""A floor's log names no task and no fingerprint: its path and the references file do."""


def ceiling_log(folder: Path, task_id: str, episodes: Sequence[Episode]) -> str:
    """Writes a task's reference runs, a rollout log; gives the sha256 of its bytes."""
    path = folder / _name(task_id)
    write_episodes(path, episodes, (task_id,))
    return _sha256(path)


def floor_log(folder: Path, task_id: str, episodes: Mapping[str, Sequence[Episode]]) -> str:
    """Writes the blind agents' episodes of a task, agent by agent; gives the sha256 of its bytes."""
    path = folder / "floors" / _name(task_id)
    lines = [",".join(FLOOR_COLUMNS)]
    for agent, rows in episodes.items():
        for row in sorted(rows, key=lambda row: row.episode):
            ended = "true" if row.terminated else "false"
            lines.append(f"{agent},{row.episode},{row.seed},{row.length},{row.return_!r},{ended}")
    write_text(path, "\n".join(lines) + "\n")
    return _sha256(path)


def _name(task_id: str) -> str:
    return f"{task_id.rpartition('/')[2]}.csv"


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()

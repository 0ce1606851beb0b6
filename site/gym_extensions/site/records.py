"""The expert of a task and the records that beat it, as the task's page shows and plays them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from gym_extensions import experts
from gym_extensions.catalog.tasks import Task
from gym_extensions.experts import Step
from gym_extensions.scoring.poses import FOLDER as POSES
from gym_extensions.scoring.poses import PolicyPoses, TaskPoses
from gym_extensions.scoring.records import Record
from gym_extensions.site.api import task_path
from gym_extensions.site.motion import Episode, Watch, WatchedTask, watched_task
from gym_extensions.site.text import short

Records = Mapping[str, tuple[Record, ...]]
"""The verified records by task id, the best one first."""


@dataclass(frozen=True)
class TaskPolicies:
    """The expert of a task and its verified records, the best one first."""

    task: Task
    records: tuple[Record, ...] = field(default=())

    @cached_property
    def shown(self) -> tuple[tuple[str, TaskPoses], ...]:
        """The poses of the expert, if they are of its policy, and of the best record, with their titles."""
        found = []
        path = experts.DATA / POSES / f"{self.task.name}.json"
        poses = PolicyPoses.load(path, "bad-poses", "gym-extensions maintain poses")
        if poses is not None and poses.policy == experts.card(self.task).policy:
            found.append(("The expert", poses.poses))
        for record in self.records[:1]:
            if record.review is not None and record.review.poses is not None:
                authors = short(", ".join(record.card.authors))
                found.append((f"The record by {authors}", record.review.poses))
        return tuple(found)

    @cached_property
    def watch(self) -> Watch | None:
        """The panel; None without poses."""
        episodes = tuple(_episodes(self.shown))
        if not episodes:
            return None
        path = task_path(self.task.id).removesuffix(".html") + "-poses.js"
        return Watch("watch-policies", path, 0, (WatchedTask(self.task.id, episodes),))

    @property
    def inputs(self) -> bytes:
        """What the page depends on."""
        return repr((self.shown, [(record.card, record.review) for record in self.records])).encode()


def _episodes(shown: tuple[tuple[str, TaskPoses], ...]) -> Iterator[Episode]:
    for title, poses in shown:
        watched = watched_task(poses)
        if watched is not None:
            (episode,) = watched.episodes
            yield Episode(episode.clip, title, poses, episode.sheet, episode.travels)


def origin(history: tuple[Step, ...]) -> str:
    """The agents of the training runs and their environment steps in words."""
    agents = ", ".join(dict.fromkeys(step.agent for step in history))
    steps = sum(step.steps or 0 for step in history)
    return f"{short(agents)}, {steps / 1e6:.1f} million steps" if steps else short(agents)

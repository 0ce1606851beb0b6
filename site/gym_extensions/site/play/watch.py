"""The Watch panel: episodes of submissions and of experts, and the script that hands them to the player.

Poses are those of ``gym_extensions.submissions.poses``.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.catalog.descriptions import Description, descriptions
from gym_extensions.catalog.tasks import TASKS
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site import paths, submission_results
from gym_extensions.site.text import count, digits_for, fixed
from gym_extensions.submissions.poses import MAX_SECONDS, Clip, Poses, TaskPoses

TRAVELLING = ("planar", "humanoid")
"""Families whose bodies move along x, so that the view follows them."""


@dataclass(frozen=True)
class Episode:
    """An episode: its clip, its cell in words, and the facts of its task.

    ``travels`` says whether its body moves along x, so that the view follows it.
    """

    clip: Clip
    title: str
    poses: TaskPoses
    description: Description
    travels: bool

    @cached_property
    def coordinates(self) -> NDArray[np.float64]:
        """The coordinates, (frames, n)."""
        return self.clip.coordinates(self.poses.unit)

    @property
    def return_(self) -> float:
        """Its return."""
        return self.clip.returns[self.clip.episode]

    @property
    def distance(self) -> float:
        """How far a travelling body comes in the part that is shown, m."""
        return float(self.coordinates[-1, 0] - self.coordinates[0, 0])

    @property
    def facts(self) -> str:
        """Return, length, distance and success in words."""
        facts = [f"return {fixed(self.return_, digits_for(self.clip.returns))}"]
        facts.append(count(self.clip.steps, "step"))
        if self.poses.steps_per_second:
            seconds = self.clip.steps / self.poses.steps_per_second
            facts[-1] += f" ({fixed(seconds, 1)} s)"
            if seconds > MAX_SECONDS:
                facts.append(f"the first {fixed(MAX_SECONDS, 0)} s are shown")
        if self.travels:
            facts.append(
                f"{fixed(abs(self.distance), 1)} m {'backward' if self.distance < -0.05 else 'forward'}"
            )
        if self.clip.success is not None:
            facts.append("success" if self.clip.success else "no success")
        return ", ".join(facts)


@dataclass(frozen=True)
class Watch:
    """The panel of one group: of each task two episodes, or one of the task that was trained last."""

    id: str
    path: str  # of the script with its poses
    run: int
    tasks: tuple[tuple[Episode, ...], ...]

    @property
    def script(self) -> str:
        """The script that hands the poses to the player, which loads it when Replay is pressed."""
        skeletons: list[Any] = []
        maps: list[Any] = []
        rows = []
        for episodes in self.tasks:
            poses, facts = episodes[0].poses, episodes[0].description
            row: dict[str, object] = {
                "unit": poses.unit,
                "rate": poses.steps_per_second / poses.steps_per_frame or 15.0,
                "clips": [[episode.clip.frames, episode.clip.motion] for episode in episodes],
            }
            if facts.skeleton is not None:
                row |= {"skeleton": _index(skeletons, facts.skeleton), "travels": episodes[0].travels}
            else:
                row |= {"map": _index(maps, facts.obstacles), "goal": facts.goal}
            rows.append(row)
        text = json.dumps({"tasks": rows, "skeletons": skeletons, "maps": maps}, separators=(",", ":"))
        return f"watchPoses({json.dumps(self.id)},{text});\n"


def _index(values: list[Any], value: Any) -> int:
    if value not in values:
        values.append(value)
    return values.index(value)


def watches(submission: Scorecard, poses: Mapping[str, Poses]) -> dict[str, Watch]:
    """The panels of a submission by group id, for groups with poses of its present results."""
    panels = {}
    for result in submission_results.results_of(submission.groups):
        shown = poses.get(result.group)
        if shown is None or not result.stage_matrices or not shown.shows(result.runs, result.stage_matrices):
            continue
        if tuple(row.task for row in shown.tasks) == result.tasks:
            path = paths.submission_file(submission.name, f"poses-{result.group}.js")
            tasks = tuple(filter(None, map(watched, shown.tasks)))
            panels[result.group] = Watch(f"watch-{result.id}", path, shown.run, tasks)
    return panels


LAST = "At the end, right after its training"
"""The title of the only episode of the task that was trained last."""


def watched(row: TaskPoses, only: str = LAST) -> tuple[Episode, ...]:
    """The episodes of a task, of which a single one is titled ``only``; none if it is not published."""
    facts, task = descriptions().get(row.task), TASKS.get(row.task)
    if facts is None or task is None:
        return ()
    travels = task.body.family in TRAVELLING
    cells = [(row.after, "Right after its training"), (row.end, "At the end")]
    if row.end is None:
        cells = [(row.after, only)]
    return tuple(Episode(clip, title, row, facts, travels) for clip, title in cells if clip is not None)

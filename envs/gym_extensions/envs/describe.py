"""The facts of a task, as ``gym-extensions envs show`` prints them."""

from __future__ import annotations

from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.task import Task
from gym_extensions.envs.build import construct


def facts(task: Task) -> str:
    """A line a fact: base, variations, spaces, time limit, groups, fingerprint."""
    env = construct(task)
    groups = [group.id for group in GROUPS.values() if task in group.tasks]
    rows = {
        "id": task.id,
        "base": task.base,
        "variations": ", ".join(map(repr, task.variations)) or "none",
        "observation": str(env.observation_space),
        "action": str(env.action_space),
        "time limit": f"{task.max_steps} steps",
        "groups": ", ".join(groups) or "none",
        "fingerprint": published(task.id),
    }
    env.close()
    return "\n".join(f"{name:<13}{value}" for name, value in rows.items())

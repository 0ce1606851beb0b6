"""The description of one task, as ``gym-extensions envs show`` prints it."""

from __future__ import annotations

from collections.abc import Iterable

from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.registry import VERSIONS
from gym_extensions.catalog.task import Task
from gym_extensions.envs.docgen.descriptions import differences
from gym_extensions.envs.docgen.tables import action_fields, indexed, observation_fields
from gym_extensions.envs.fields import Field

PICTURE = "uint8 picture, 120 rows × 160 columns × 3 colors, 4 units per pixel, y up"


def summary(task: Task) -> str:
    """Returns base, differences, reward, start, end, tables, groups, versions and fingerprint of a task."""
    prose = task.body.prose
    observation = observation_fields(task)
    groups = [group.id for group in GROUPS.values() if task in group.tasks]
    facts = {
        "base": task.base,
        "what": prose.summary,
        "differs": " ".join(differences(task)) or "nothing",
        "reward": prose.reward,
        "start": prose.start,
        "end": prose.end,
        "time limit": f"{task.max_steps} steps",
        "success": task.body.success.text if task.body.success else "not defined",
        "source": prose.source,
        "groups": ", ".join(groups) or "none",
        "versions": "; ".join(f"v{number}: {VERSIONS[number]}" for number in range(task.version + 1)),
        "fingerprint": published(task.id),
    }
    lines = [task.id, *(f"  {name:<13}{value}" for name, value in facts.items())]
    lines += ["", *_table("action", action_fields(task)), ""]
    lines += _table("observation", observation) if observation else [f"observation: {PICTURE}"]
    return "\n".join(lines)


def _table(title: str, fields: Iterable[Field]) -> list[str]:
    rows = [("index", "meaning", "unit", "range")]
    rows += [(index, field.meaning, field.unit, field.range) for index, field in indexed(fields)]
    widths = [max(len(row[column]) for row in rows) for column in range(4)]
    count = sum(field.count for field in fields)
    return [
        f"{title} ({count} numbers)",
        *(
            "  " + "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip()
            for row in rows
        ),
    ]

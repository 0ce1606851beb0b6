"""Submissions on disk for tests that score them."""

from pathlib import Path

import msgspec

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import BUDGETS
from gym_extensions.references import Expert, Floor, Reference, References
from gym_extensions.submissions.run import read_run, write_run

from ..conftest import MANIFEST, write_submission

HOPPER = "hopper-gravity"
REFERENCES = References(
    "made-up", {task: Reference(Floor(0.0), Expert(100.0)) for task in group(HOPPER).task_ids}, "0f" * 32
)
"""Floor 0 and expert 100 on every task of the group."""


def value(_protocol: str, run: int, stage: int, position: int, episode: int) -> float:
    """Returns of about 20, and of about 50 from the training on the task on."""
    return 20.0 + 30 * (stage >= position) + run + episode / 7


def make_submission(root: Path, name: str, runs: int = 2) -> Path:
    """A sequential submission on hopper-gravity with the budget 100k, and its folder."""
    manifest = MANIFEST.replace('"smoke"', '"100k"').replace("Made up", name.title())
    title = next(line for line in MANIFEST.splitlines() if line.startswith("title"))
    folder = write_submission(
        root,
        name=name,
        runs=tuple(range(runs)),
        protocols=("sequential",),
        value=value,
        manifest=manifest.replace(title, f'title = "{name.title()}"'),
    )
    for path in folder.rglob("run*.json"):
        steps = BUDGETS["100k"].steps_for(HOPPER) * len(group(HOPPER).tasks)
        write_run(path, msgspec.structs.replace(read_run(path), steps=steps))
    return folder

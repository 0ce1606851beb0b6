"""The last value that a rule allows, and the first that it refuses."""

import os
import shutil
from collections.abc import Callable
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import BUDGETS
from gym_extensions.submissions.layout import MAX_FILE_BYTES
from gym_extensions.submissions.reader import read

from ..examples import (
    DOCUMENT,
    GROUP,
    HALF,
    TOML,
    Change,
    CopySubmission,
    all_of,
    cell,
    document,
    edit,
    put,
    redigest,
)

STEPS = BUDGETS["smoke"].steps_for(GROUP)
TASK = group(GROUP).tasks[0]
LOW, HIGH = TASK.return_bounds
MOST, LEAST = 3 * TASK.body.rewards.high + TASK.body.rewards.end, 3 * TASK.body.rewards.low
"""The highest and lowest return of an episode of three steps."""


Limit = tuple[Callable[[Any], Change], float, float, str]
"""A change by a value, the last value that is allowed, the first that is refused, and by which rule."""


def curve(step: int = 10, value: float = 1.0, name: str = "curves", **others: object) -> Change:
    return document(
        DOCUMENT, **{name: [{"stage": 1, "task": HALF, "steps": [step], "returns": [value]} | others]}
    )


def episode(length: int, return_: float = 1.0) -> Change:
    """Writes another first episode, which ends early."""
    cells = {4: str(length), 5: repr(return_), 6: "true"}
    return redigest(all_of(*(cell(2, column, value) for column, value in cells.items())))


def called(characters: int) -> Change:
    return lambda folder: folder.rename(folder.with_name("x" * characters))


EVALUATED = partial(curve, name="evaluations")
README = MAX_FILE_BYTES[".md"]
LIMITS: dict[str, Limit] = {
    "steps of a run": (
        *(lambda steps: document(steps=steps), int(1.02 * 5 * STEPS), int(1.02 * 5 * STEPS) + 1),
        "over-budget",
    ),
    "steps of a curve": (curve, int(1.02 * STEPS), int(1.02 * STEPS) + 1, "over-budget"),
    "first step": (curve, 1, 0, "curve-order"),
    "highest mean return": (lambda value: curve(value=value), HIGH, HIGH + 0.1, "impossible-curve-return"),
    "lowest mean return": (lambda value: curve(value=value), LOW, LOW - 0.1, "impossible-curve-return"),
    "end": (lambda step: EVALUATED(step, episodes=5), STEPS - 1, STEPS, "impossible-evaluation"),
    "one episode": (lambda count: EVALUATED(episodes=count), 1, 0, "impossible-evaluation"),
    "twenty episodes": (lambda count: EVALUATED(episodes=count), 20, 21, "impossible-evaluation"),
    "a step": (episode, 1, 0, "impossible-length"),
    "highest return": (lambda value: episode(3, value), MOST, MOST + 0.1, "impossible-return"),
    "lowest return": (lambda value: episode(3, value), LEAST, LEAST - 0.1, "impossible-return"),
    "title": (lambda count: edit("A submission", "x" * count, TOML), 100, 101, "bad-value"),
    "description": (lambda count: edit("Made up by a formula.", "x" * count, TOML), 4000, 4001, "bad-value"),
    "counts": (lambda count: edit("steps = 0", f"steps = {count}", TOML), 2**53 - 1, 2**53, "bad-value"),
    "marks": (lambda count: edit("A sub", "e" + "\u0301" * count, TOML), 5, 6, "control-character"),
    "README": (lambda size: put("README.md", b"x" * size), README, README + 1, "too-large"),
    "name": (called, 64, 65, "folder-name"),
}


@pytest.mark.parametrize("limit", LIMITS.values(), ids=LIMITS)
def test_the_limit_is_where_it_is_said_to_be(good: CopySubmission, tmp_path: Path, limit: Limit) -> None:
    change, allowed, refused, rule = limit
    for name, value, expected in (("a", allowed, set()), ("b", refused, {rule})):
        root = tmp_path / name
        root.mkdir()
        change(value)(good(GROUP, root))
        assert {problem.rule for problem in read(next(root.iterdir())).problems} == expected


@pytest.mark.parametrize(("last", "problems"), [(99, 0), (100, 1)])
def test_at_most_a_hundred_runs(folder: Path, last: int, problems: int) -> None:
    shutil.rmtree(folder / GROUP / "sequential")
    path = folder / GROUP / "single"
    for run, suffix in product(range(2, last + 1), (".csv", ".json")):
        os.link(path / f"run1{suffix}", path / f"run{run}{suffix}")
    found = [problem for problem in read(folder).problems if problem.rule == "gaps-in-runs"]
    assert len(found) == problems

"""The last value that a rule allows, and the first that it refuses."""

import os
from pathlib import Path

import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import BUDGETS
from gym_extensions.submissions.layout import MAX_FILE_BYTES, max_bytes
from gym_extensions.submissions.reader import read

from ..examples import (
    DOCUMENT,
    GROUP,
    HALF,
    LOG,
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
REWARDS = TASK.body.rewards


def curve(step: int = 10, value: float = 1.0, episodes: int | None = None, name: str = "curves") -> Change:
    part = {"stage": 1, "task": HALF, "steps": [step], "returns": [value]}
    return document(DOCUMENT, **{name: [part if episodes is None else part | {"episodes": episodes}]})


def evaluation(step: int = 10, episodes: int = 5) -> Change:
    return curve(step, 1.0, episodes, "evaluations")


def episode(length: int, return_: float, terminated: str) -> Change:
    cells = {4: str(length), 5: repr(return_), 6: terminated}
    return redigest(all_of(*(cell(2, column, value) for column, value in cells.items())))


def short(steps: int, beyond: float = 0.0, *, high: bool = True) -> Change:
    """An episode of this length with the highest or lowest return, and a little more."""
    bound = steps * REWARDS.high + REWARDS.end if high else steps * REWARDS.low
    return episode(steps, bound + beyond, "true")


LIMITS: list[tuple[str, Change, Change, str]] = [
    (
        "steps of a run",
        document(steps=int(1.02 * 5 * STEPS)),
        document(steps=int(1.02 * 5 * STEPS) + 1),
        "over-budget",
    ),
    ("steps of a curve", curve(int(1.02 * STEPS)), curve(int(1.02 * STEPS) + 1), "over-budget"),
    ("first step", curve(1), curve(0), "curve-order"),
    ("highest mean return", curve(value=HIGH), curve(value=HIGH + 0.1), "impossible-curve-return"),
    ("lowest mean return", curve(value=LOW), curve(value=LOW - 0.1), "impossible-curve-return"),
    ("step before the end", evaluation(STEPS - 1), evaluation(STEPS), "impossible-evaluation"),
    ("one episode", evaluation(episodes=1), evaluation(episodes=0), "impossible-evaluation"),
    ("twenty episodes", evaluation(episodes=20), evaluation(episodes=21), "impossible-evaluation"),
    ("a step", episode(1, 1.0, "true"), episode(0, 1.0, "true"), "impossible-length"),
    ("the time limit", episode(1000, 1.0, "false"), episode(1001, 1.0, "false"), "impossible-length"),
    ("an end", episode(999, 1.0, "true"), episode(999, 1.0, "false"), "unfinished-episode"),
    ("highest return", short(3), short(3, 0.1), "impossible-return"),
    ("lowest return", short(3, high=False), short(3, -0.1, high=False), "impossible-return"),
    ("title", edit("A submission", "x" * 100, TOML), edit("A submission", "x" * 101, TOML), "bad-value"),
    (
        "description",
        edit("Made up by a formula.", "x" * 4000, TOML),
        edit("Made up by a formula.", "x" * 4001, TOML),
        "bad-value",
    ),
    (
        "counts",
        edit("steps = 0", f"steps = {2**53 - 1}", TOML),
        edit("steps = 0", f"steps = {2**53}", TOML),
        "bad-value",
    ),
    (
        "marks",
        edit("A submission", "e" + "\u0301" * 5, TOML),
        edit("A submission", "e" + "\u0301" * 6, TOML),
        "control-character",
    ),
    (
        "README",
        put("README.md", b"x" * MAX_FILE_BYTES[".md"]),
        put("README.md", b"x" * (MAX_FILE_BYTES[".md"] + 1)),
        "too-large",
    ),
    (
        "name",
        lambda folder: folder.rename(folder.with_name("x" * 64)),
        lambda folder: folder.rename(folder.with_name("x" * 65)),
        "folder-name",
    ),
]


@pytest.mark.parametrize(
    ("allowed", "refused", "rule"), [row[1:] for row in LIMITS], ids=[row[0] for row in LIMITS]
)
def test_the_limit_is_where_it_is_said_to_be(
    good: CopySubmission, tmp_path: Path, allowed: Change, refused: Change, rule: str
) -> None:
    for name, change, expected in (("a", allowed, set()), ("b", refused, {rule})):
        root = tmp_path / name
        root.mkdir()
        change(good(GROUP, root))
        assert {problem.rule for problem in read(next(root.iterdir())).problems} == expected


@pytest.mark.parametrize(("last", "problems"), [(99, 0), (100, 2)])
def test_at_most_a_hundred_runs(good: CopySubmission, tmp_path: Path, last: int, problems: int) -> None:
    folder = good(GROUP, tmp_path)
    for protocol in ("sequential", "single"):
        for run in range(2, last + 1):
            for suffix in (".csv", ".json"):
                path = folder / GROUP / protocol
                os.link(path / f"run1{suffix}", path / f"run{run}{suffix}")
    found = [problem for problem in read(folder).problems if problem.rule == "gaps-in-runs"]
    assert len(found) == problems


def test_every_kind_of_file_has_a_limit() -> None:
    kib = {TOML: 256, LOG: 8192, "README.md": 64, "x/joint/run0.json": 4096, "x/joint/run0.npz": 65536}
    kib |= {"review.toml": 65536, "poses/x.json": 65536, "x": 1024}
    assert {path: max_bytes(path) // 2**10 for path in kib} == kib

"""Rules about the column success."""

from __future__ import annotations

from pathlib import Path

from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, evaluation_seed
from gym_extensions.envs.fingerprint import fingerprint_of
from gym_extensions.rollouts.episodes import Episode, write_episodes

from ..examples import LOG, Check, Example, all_of, cell, parametrize

STANDUP = "humanoid-standup-run"  # Humanoid defines no success, the other two tasks do
STANDUP_LOG = f"{STANDUP}/sequential.csv"
NAVIGATION_LOG = "nav-state/single.csv"


def add_navigation(folder: Path) -> None:
    """Adds a log of navigation in which no episode reaches the goal."""
    members = group("nav-state")
    rows = [
        Episode(
            *(0, 1, task.id, episode, evaluation_seed(members.id, task.id, episode)),
            *(1000, -1000.0 - episode, False, False, fingerprint_of(task)),
        )
        for task in members.tasks
        for episode in range(EVALUATION_EPISODES)
    ]
    write_episodes(folder / NAVIGATION_LOG, rows, members.task_ids)


EXAMPLES = (
    Example(
        "missing-success",
        "an empty cell in a task that defines success",
        cell(22, 8, "", STANDUP_LOG),
        (
            (
                f"{STANDUP_LOG}, row 22",
                "Column `success` is empty, but gym_extensions/HumanoidStandup-v0 defines success.",
                'Write info["is_success"] of the last step of the episode.',
            ),
        ),
        group=STANDUP,
    ),
    Example(
        "undefined-success",
        "true and false in tasks that define none",
        all_of(cell(2, 8, "true"), cell(3, 8, "false")),
        tuple(
            (
                f"{LOG}, row {number}",
                f"Column `success` is {value}, but gym_extensions/HopperGravityHalf-v0 defines no success.",
                "Leave the cell empty.",
            )
            for number, value in ((2, "true"), (3, "false"))
        ),
    ),
    Example(
        "contradictory-success",
        "success in navigation without an arrival",
        all_of(add_navigation, cell(3, 8, "true", NAVIGATION_LOG)),
        (
            (
                f"{NAVIGATION_LOG}, row 3",
                "Column `success` is true, but `terminated` is false.",
                "This task ends at the goal, and only there: write the same value in both columns.",
            ),
        ),
    ),
    Example(
        "bad-cell",
        "True in place of true",
        cell(2, 8, "True"),
        (
            (
                f"{LOG}, row 2",
                "Column `success` is 'True'; expected true, false or nothing.",
                "Write true, false or nothing.",
            ),
        ),
    ),
)


@parametrize(EXAMPLES)
def test_the_rule_reports_these_problems_and_no_other(example: Example, check: Check) -> None:
    check(example)

"""Rules about submission.toml and the folder together."""

from __future__ import annotations

import shutil
from pathlib import Path

from gym_extensions.catalog.published import REPORTS, TABLES
from gym_extensions.rollouts.reader import read

from .broken import GROUP, TOML, Broken, Judge, Spoil, each, edit

PAPER = Path(__file__).parents[3] / "submissions" / "henderson2017-trpo" / TOML
OWN_RUNS = "Leave out the key 'reported', and write the logs of your own runs."


def paper(name: str, *edits: tuple[str, str]) -> Spoil:
    """Puts the paper's entry, edited, into a folder of that name."""

    def spoil(folder: Path) -> None:
        shutil.rmtree(folder)
        folder.with_name(name).mkdir()
        shutil.copy(PAPER, folder.with_name(name))
        for old, new in edits:
            edit(old, new, TOML)(folder.with_name(name))

    return spoil


BROKEN = (
    Broken(
        "no-groups",
        "a submission.toml alone",
        lambda folder: shutil.rmtree(folder / GROUP),
        (
            (
                "entry",
                "There is no group's folder in it.",
                "Add the folders of the groups, as docs/rollout-log.md says.",
            ),
        ),
    ),
    Broken(
        "logs-of-a-reported-entry",
        "a published table with logs",
        edit("format = 1", 'format = 1\nreported = "henderson2017"', TOML),
        (
            (
                GROUP,
                "A reported entry has no logs.",
                "Remove the key 'reported' from submission.toml, or the folder.",
            ),
        ),
        also=("foreign-report",),
    ),
    Broken(
        "foreign-report",
        "a published table under another name, budget and algorithm",
        paper("ours", ('"paper"', '"100k"'), ('algorithm = "trpo"', 'algorithm = "ours"')),
        (
            ("ours", "The table 'henderson2017' stands in the folder 'henderson2017-trpo'.", OWN_RUNS),
            (
                f"{TOML}, [protocol] budget",
                "The value is '100k'; the table 'henderson2017' has 'paper'.",
                "Write 'paper'.",
            ),
            (
                f"{TOML}, [protocol] algorithm",
                "The value is 'ours'; the table 'henderson2017' has 'trpo'.",
                "Write 'trpo'.",
            ),
        ),
    ),
)


@each(BROKEN)
def test_a_broken_folder_breaks_its_rule_and_says_so(example: Broken, judge: Judge) -> None:
    judge(example)


def test_every_published_table_has_its_entry() -> None:
    assert set(REPORTS) == set(TABLES)
    assert read(PAPER.parent).problems == ()

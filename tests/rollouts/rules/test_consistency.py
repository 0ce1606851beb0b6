"""Rules about submission.toml and the folder together."""

from __future__ import annotations

import shutil
from pathlib import Path

from gym_extensions.catalog.published import REPORTS, TABLES
from gym_extensions.rollouts.reader import read

from ..examples import GROUP, TOML, Change, Check, Example, edit, parametrize

PAPER = Path(__file__).parents[3] / "submissions" / "henderson2017-trpo" / TOML
OWN_RUNS = "Remove the key 'reported', and submit the logs of your own runs."


def paper(name: str, *edits: tuple[str, str]) -> Change:
    """Puts the paper's entry, edited, into a folder of that name."""

    def change(folder: Path) -> None:
        shutil.rmtree(folder)
        folder.with_name(name).mkdir()
        shutil.copy(PAPER, folder.with_name(name))
        for old, new in edits:
            edit(old, new, TOML)(folder.with_name(name))

    return change


EXAMPLES = (
    Example(
        "no-groups",
        "a submission.toml alone",
        lambda folder: shutil.rmtree(folder / GROUP),
        (
            (
                "entry",
                "The submission contains no group folder.",
                "Add group folders, as described in docs/rollout-log.md.",
            ),
        ),
    ),
    Example(
        "logs-of-a-reported-entry",
        "a published table with logs",
        edit("format = 1", 'format = 1\nreported = "henderson2017"', TOML),
        (
            (
                GROUP,
                "A reported entry cannot contain a group folder.",
                "Remove the key 'reported' from submission.toml, or remove the folder.",
            ),
        ),
        also=("foreign-report",),
    ),
    Example(
        "foreign-report",
        "a published table under another name, budget and algorithm",
        paper("ours", ('"paper"', '"100k"'), ('algorithm = "trpo"', 'algorithm = "ours"')),
        (
            ("ours", "The table 'henderson2017' belongs to the folder 'henderson2017-trpo'.", OWN_RUNS),
            (
                f"{TOML}, [protocol] budget",
                "The value is '100k'; expected 'paper' for the table 'henderson2017'.",
                "Write 'paper'.",
            ),
            (
                f"{TOML}, [protocol] algorithm",
                "The value is 'ours'; expected 'trpo' for the table 'henderson2017'.",
                "Write 'trpo'.",
            ),
        ),
    ),
)


@parametrize(EXAMPLES)
def test_the_rule_reports_these_problems_and_no_other(example: Example, check: Check) -> None:
    check(example)


def test_every_published_table_has_its_entry() -> None:
    assert set(REPORTS) == set(TABLES)
    assert read(PAPER.parent).problems == ()

"""Rules about submission.toml and the folder together."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

from gym_extensions.catalog.published import REPORTS, TABLES
from gym_extensions.rollouts.reader import read

from ..examples import GROUP, TOML, Change, Check, Example, cell, edit, parametrize

PAPER = Path(__file__).parents[3] / "submissions" / "henderson2017-trpo" / TOML
OWN_RUNS = "Remove the key 'reported', and submit the logs of your own runs."


def append(path: str, text: str) -> Change:
    """Adds text to the end of a file."""
    return lambda folder: (folder / path).open("a").write(text)


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
        "different-root",
        "a root of logs without the column `trace`",
        append(TOML, f'\n[traces]\nroot = "{64 * "0"}"\n'),
        (
            (
                f"{TOML}, [traces] root",
                "No log has the column `trace`.",
                "Remove the section [traces].",
            ),
        ),
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


def root_of(submission: Callable[..., Path], change: Change) -> tuple[str, ...]:
    folder = submission(runs=(0,), traces=True)
    assert read(folder).problems == ()
    change(folder)
    return tuple(f"{problem.rule}: {problem.message}" for problem in read(folder).problems)


def test_a_changed_digest_or_root_is_reported(submission: Callable[..., Path]) -> None:
    (problem,) = root_of(submission, cell(2, 9, 32 * "0"))
    assert problem.startswith("different-root: The root is '")
    assert "; the logs have the root " in problem


def test_a_missing_root_is_reported(submission: Callable[..., Path]) -> None:
    (problem,) = root_of(submission, edit("[traces]\nroot = ", '[archive]\nurl = ""\nsha256 = ', TOML))
    assert problem.startswith("different-root: The root is missing; the logs have the root ")


def test_logs_with_and_without_traces_are_reported(submission: Callable[..., Path]) -> None:
    def unbind(folder: Path) -> None:
        path = folder / GROUP / "single.csv"
        rows = [line.split(",") for line in path.read_text().splitlines()]
        lines = [",".join([*cells[:9], cells[10]]) for cells in rows]
        path.write_text("\n".join([*lines, ""]), newline="\n")

    assert root_of(submission, unbind) == (
        "different-root: Some logs of the submission have the column `trace`, and others do not.",
    )


def test_a_digest_of_the_wrong_form_is_reported(submission: Callable[..., Path]) -> None:
    assert root_of(submission, cell(2, 9, 31 * "a" + "G")) == (
        "bad-cell: Column `trace` is 'aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaG'; expected 32 hexadecimal digits "
        "(0 to 9, a to f).",
    )

"""Every rule reports the mistakes of its examples, and no other rule does."""

from pathlib import Path

import pytest

from gym_extensions.submissions.reader import read
from gym_extensions.submissions.rules import RULES

from ..examples import GROUP, CopySubmission, Example
from . import run_document, test_agent, test_folder, test_log, test_manifest, test_policies

TABLES = (test_agent, test_folder, test_manifest, run_document, test_log, test_policies)
EXAMPLES = [
    Example(rule, *row) for module in TABLES for rule, rows in module.EXAMPLES.items() for row in rows
]


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: f"{example.rule}: {example.title}")
def test_the_rule_reports_this_problem_and_no_other_rule_does(
    example: Example, good: CopySubmission, tmp_path: Path
) -> None:
    folder = good(example.group, tmp_path)
    # The formula gives returns that some groups never have.
    before = () if example.group == GROUP else read(folder, policies=True).problems
    example.change(folder)
    after = read(folder if folder.exists() else next(tmp_path.iterdir()), policies=True).problems
    problems = [problem for problem in after if problem not in before]
    found = [problem for problem in problems if problem.rule == example.rule]
    assert {problem.rule for problem in problems} == {example.rule, *example.also}
    assert found[0].where == example.where
    assert example.fact in f"{found[0].message} {found[0].hint}"
    assert len(found) == example.count


def test_every_rule_has_an_example() -> None:
    elsewhere = {"unreadable-file"}  # test_an_unreadable_file_is_named
    assert {example.rule for example in EXAMPLES} | elsewhere == set(RULES)

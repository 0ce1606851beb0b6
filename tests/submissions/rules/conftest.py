"""Checks an example of a broken rule."""

from pathlib import Path

import pytest

from gym_extensions.submissions.reader import read

from ..examples import GROUP, Check, CopySubmission, Example


@pytest.fixture
def check(good: CopySubmission, tmp_path: Path) -> Check:
    """The example's rule reports the problem, and only the named other rules are broken."""

    def compare(example: Example) -> None:
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

    return compare

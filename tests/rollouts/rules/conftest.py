"""Checks an example of a broken rule."""

from __future__ import annotations

from pathlib import Path

import pytest

from gym_extensions.catalog.fingerprints import published
from gym_extensions.rollouts.reader import read

from ..examples import HALF, Check, CopySubmission, Example


@pytest.fixture
def check(good: CopySubmission, tmp_path: Path) -> Check:
    """The example's rule reports exactly the expected problems, and only the named other rules are broken."""

    def compare(example: Example) -> None:
        folder = good(example.group, tmp_path)
        example.change(folder)
        problems = read(folder if folder.exists() else next(tmp_path.iterdir())).problems
        findings = tuple((p.where, p.message, p.hint) for p in problems if p.rule == example.rule)
        assert findings == tuple(
            (where, message.replace("'HALF'", repr(published(HALF))), hint)
            for where, message, hint in example.findings
        )
        assert {p.rule for p in problems} == {example.rule, *example.also}

    return compare

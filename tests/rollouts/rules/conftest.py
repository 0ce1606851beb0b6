"""How a broken folder is judged."""

from __future__ import annotations

from pathlib import Path

import pytest

from gym_extensions.catalog.fingerprints import published
from gym_extensions.rollouts.reader import read

from .broken import HALF, Broken, Good, Judge


@pytest.fixture
def judge(good: Good, tmp_path: Path) -> Judge:
    """Spoils a good folder: the example's rule tells exactly its words, and no other rule is broken."""

    def check(example: Broken) -> None:
        folder = good(example.group, tmp_path)
        example.spoil(folder)
        problems = read(folder if folder.exists() else next(tmp_path.iterdir())).problems
        told = tuple((one.where, one.message, one.hint) for one in problems if one.rule == example.rule)
        expected = tuple(
            (where, message.replace("'HALF'", repr(published(HALF))), hint)
            for where, message, hint in example.told
        )
        assert told == expected
        assert {one.rule for one in problems} == {example.rule, *example.also}

    return check

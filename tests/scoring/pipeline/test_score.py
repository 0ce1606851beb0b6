"""Many submissions at once: in order, with bounded memory, and an unforeseen error stops no other."""

from __future__ import annotations

import time
import tracemalloc
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import pytest

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.reader import read
from gym_extensions.scoring.pipeline import score as pipeline
from gym_extensions.scoring.pipeline.score import QUEUED_PER_WORKER, Scorer, find_submissions, scorecards
from gym_extensions.scoring.references import References
from gym_extensions.scoring.scorecard.model import Scorecard


def test_memory_does_not_grow_with_the_number_of_submissions(
    writer: Callable[..., Path], references: References, tmp_path: Path
) -> None:
    folders = [writer(tmp_path, name=f"e{number}", protocols=("single",)) for number in range(16)]
    list(islice(scorecards(folders, Scorer(references), workers=1), 2))

    def peak(count: int) -> int:
        tracemalloc.start()
        for _ in scorecards(folders[:count], Scorer(references), workers=1):
            pass
        bytes_at_peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return bytes_at_peak

    # A log has 30 kB of text and its scorecard 10 kB: neither is held.
    assert (peak(16) - peak(4)) / 12 < 8_000


@dataclass(frozen=True)
class Marking(Scorer):
    """Scores nothing and leaves a file for each folder that it is called with."""

    def __call__(self, path: Path) -> Scorecard:
        path.touch()
        return Scorecard(name=path.name, title="", trust=None, manifest=None)


def test_workers_do_not_run_far_ahead_of_the_consumer(tmp_path: Path, references: References) -> None:
    folders = [tmp_path / f"e{number:02}" for number in range(40)]
    cards = scorecards(folders, Marking(references), workers=2)
    first = next(cards)
    time.sleep(1)
    assert len(list(tmp_path.iterdir())) <= 2 * QUEUED_PER_WORKER + 1
    assert [card.name for card in [first, *cards]] == [path.name for path in folders]


def test_an_unforeseen_error_is_a_problem_of_that_submission_alone(
    submission: Callable[..., Path], references: References, monkeypatch: pytest.MonkeyPatch
) -> None:
    folders = [submission(name=name) for name in "ab"]

    def failing(path: Path, groups: Mapping[str, TaskGroup]) -> object:
        if path.name == "a":
            raise ZeroDivisionError
        return read(path, groups)

    monkeypatch.setattr(pipeline, "read", failing)
    broken, good = scorecards(folders, Scorer(references), workers=1)
    (problem,) = broken.problems
    assert (problem.rule, problem.where) == ("fault-of-the-scorer", "a")
    assert "ZeroDivisionError" in problem.message
    assert "please report it" in problem.hint
    assert good.trust == "validated"


def test_a_path_that_does_not_exist_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(BenchError) as raised:
        find_submissions([tmp_path / "nowhere"])
    assert str(raised.value) == (
        f"{tmp_path / 'nowhere'}: There is no such folder. Name a submission, or a folder of submissions."
    )

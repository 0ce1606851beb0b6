"""Many submissions at once: none is held longer than it takes to hand it on."""

from __future__ import annotations

import time
import tracemalloc
from collections.abc import Callable
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from gym_extensions.scoring.pipeline.batch import AHEAD, Work, cards
from gym_extensions.scoring.references import References


def test_memory_does_not_grow_with_the_number_of_submissions(
    writer: Callable[..., Path], references: References, tmp_path: Path
) -> None:
    folders = [writer(tmp_path, name=f"e{number}", protocols=("single",)) for number in range(16)]
    list(islice(cards(folders, Work(references), workers=1), 2))

    def peak(count: int) -> int:
        tracemalloc.start()
        for _ in cards(folders[:count], Work(references), workers=1):
            pass
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    # A log here has 30 kB of text and its scorecard 10 kB: neither is held.
    assert (peak(16) - peak(4)) / 12 < 8_000


@dataclass(frozen=True)
class Marked(Work):
    """Scores nothing, and leaves a mark for each folder that it was given."""

    def __call__(self, path: Path) -> dict[str, str]:
        path.touch()
        return {"name": path.name}


def test_workers_do_not_run_far_ahead_of_who_takes_the_scorecards(
    references: References, tmp_path: Path
) -> None:
    folders = [tmp_path / f"e{number:02}" for number in range(40)]
    taken = cards(folders, Marked(references), workers=2)
    first = next(taken)
    time.sleep(1)
    assert len(list(tmp_path.iterdir())) <= 2 * AHEAD + 1
    assert [first, *taken] == [{"name": path.name} for path in folders]

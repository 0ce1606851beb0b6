"""Many submissions at once: none is held longer than it takes to hand it on."""

from __future__ import annotations

import importlib
import time
import tracemalloc
from collections.abc import Callable
from itertools import islice
from pathlib import Path

import pytest

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


def test_workers_do_not_run_far_ahead_of_the_consumer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The work is in a module that every worker can import, because Python 3.14 no longer forks its workers.
    (tmp_path / "leaves_a_mark.py").write_text(
        "def work(path):\n    path.touch()\n    return {'name': path.name}\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    work = importlib.import_module("leaves_a_mark").work
    folders = [tmp_path / "marks" / f"e{number:02}" for number in range(40)]
    (tmp_path / "marks").mkdir()
    taken = cards(folders, work, workers=2)
    first = next(taken)
    time.sleep(1)
    assert len(list((tmp_path / "marks").iterdir())) <= 2 * AHEAD + 1
    assert [first, *taken] == [{"name": path.name} for path in folders]

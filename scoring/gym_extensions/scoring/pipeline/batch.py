"""Many submissions and their boards: side by side, one at a time in memory, in the order of their names."""

from __future__ import annotations

import os
import traceback
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

from gym_extensions.errors import BenchError
from gym_extensions.rollouts.folder import scan
from gym_extensions.rollouts.layout import NAME
from gym_extensions.rollouts.problem import Problem, escape
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.submission import Submission
from gym_extensions.scoring.leaderboard.board import board
from gym_extensions.scoring.leaderboard.keys import BoardKey, board_keys, part
from gym_extensions.scoring.output.json import Made, made, text
from gym_extensions.scoring.pipeline.cache import content_key, keep, kept
from gym_extensions.scoring.references import References
from gym_extensions.scoring.scorecard.build import score

WORTH_WORKERS = 6
"""From so many submissions on, starting further processes pays."""
WAITING = 1
"""So many processes more than cores: while one waits for the disk, another works."""
AHEAD = 4
"""So many submissions a process are under way or wait to be taken, however slow who takes them is."""
MANY_ENTRIES = 100
"""From so many submissions on, it pays for their boards."""
BOARD_DEPTH = 2
"""A board lies in the list of boards, which lies in the document."""


@dataclass(frozen=True)
class Work:
    """What scores one folder: the references, and where scorecards are kept (nowhere, if None)."""

    references: References
    cache: Path | None = None

    def __call__(self, path: Path) -> dict[str, Any]:
        """The scorecard of the submission in that folder, one with a problem where scoring it breaks down."""
        try:
            return self._card(path)
        except BenchError:
            raise
        except Exception as fault:  # noqa: BLE001 - a folder that we have not foreseen must not stop the others
            return score(Submission(escape(path.name), None, {}, (_fault(path, fault),)), self.references)

    def _card(self, path: Path) -> dict[str, Any]:
        if self.cache is None or not NAME.fullmatch(path.name):
            return score(read(path), self.references)
        folder = scan(path)
        place = self.cache / f"{folder.name}.json"
        key = content_key(folder, self.references.digest)
        card = kept(place, key)
        if card is None:
            card = score(read(path), self.references)
            keep(place, key, card)
        return card


def _fault(path: Path, fault: Exception) -> Problem:
    last = traceback.extract_tb(fault.__traceback__)[-1]
    found = f"The scorer stopped with {type(fault).__name__} in {Path(last.filename).name}, {last.name}."
    hint = "This is a mistake of gym-extensions, whatever the folder holds: please report it."
    return Problem("fault-of-the-scorer", escape(path.name), found, hint)


def cards(folders: Sequence[Path], work: Work, workers: int | None = None) -> Iterator[dict[str, Any]]:
    """The scorecards of the folders, one by one in their order, whatever the number of worker processes."""
    count = min(workers or (os.cpu_count() or 1) + WAITING, len(folders))
    if count < 2 or (workers is None and len(folders) < WORTH_WORKERS):
        yield from map(work, folders)
        return
    with ProcessPoolExecutor(count) as pool:
        waiting = iter(folders)
        ahead = deque(pool.submit(work, path) for path in islice(waiting, count * AHEAD))
        while ahead:
            card = ahead.popleft().result()
            ahead.extend(pool.submit(work, path) for path in islice(waiting, 1))
            yield card


def _made_board(slims: Sequence[dict[str, Any]], key: BoardKey) -> Made:
    return made(board(slims, key), BOARD_DEPTH)


def boards_text(slims: Sequence[dict[str, Any]], workers: int | None = None) -> str:
    """The document of all boards of slim scorecards, the same whatever the number of worker processes."""
    keys = board_keys(slims)
    parts = ([part(card, key) for card in slims] for key in keys)
    count = min(workers or os.cpu_count() or 1, len(keys))
    if count < 2 or len(slims) < MANY_ENTRIES:
        found = list(map(_made_board, parts, keys))
    else:
        with ProcessPoolExecutor(count) as pool:
            found = list(pool.map(_made_board, parts, keys))
    return text({"format": 1, "boards": found})

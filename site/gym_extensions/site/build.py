"""Builds the site from scorecards. The same scorecards give the same bytes.

Scorecards are read one after another: the files of a submission are written from its whole scorecard, and the
pages that show many submissions are written at the end, from what ``shortened`` keeps of each.
"""

import gc
import hashlib
import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from filelock import FileLock, Timeout

from gym_extensions.errors import BenchError
from gym_extensions.scoring.scorecard import Scorecard
from gym_extensions.site import FOLDER, board_views, paths
from gym_extensions.site.pages.page import File, Render

COLLECTED_FILES = 500
"""Number of files after which unused objects of their pages are removed from memory."""


@dataclass
class Site:
    """The files of a site, as its scorecards come."""

    render: Render
    cards: dict[str, Scorecard] = field(default_factory=dict)

    @cached_property
    def leaderboard(self) -> board_views.Leaderboard:
        """All submissions and their boards. No submission may follow."""
        cards = tuple(self.cards[name] for name in sorted(self.cards))
        return board_views.Leaderboard(self.render.references, cards)

    def files(self, cards: Iterable[Scorecard]) -> Iterator[File]:
        """Every file: those of each submission as it comes, then those that are made from all submissions.

        Raises ``BenchError`` if a submission has the name of one before it.
        """
        for card in cards:
            if card.name in self.cards:
                hint = "Rename one of the folders."
                raise BenchError("same-name", f"Two submissions have the name {card.name!r}.", hint=hint)
            for page in self.render.pages:
                yield from page.publish_submission(card, self.render) if page.publish_submission else ()
            self.cards[card.name] = board_views.shortened(card)
        for page in self.render.pages:
            yield from page.publish(self.leaderboard, self.render) if page.publish else ()
        for file in sorted((FOLDER / "static").rglob("*.*")):
            yield file.relative_to(FOLDER).as_posix(), file.read_bytes()


def build_site(cards: Iterable[Scorecard], render: Render, out: Path) -> board_views.Leaderboard:
    """Writes the site and returns what it shows.

    All files are written into a folder beside ``out``, which then takes its place: a build that fails or is
    interrupted leaves the site that was there.

    Args:
        cards: scorecards, which may come from a generator: only one is in memory at a time.
        render: the kinds of pages, and what fills them beside the scorecards.
        out: the folder.

    Raises:
        BenchError: ``out`` exists and is neither empty nor a site, it cannot be written, another process
            builds it, or two submissions have the same name.
    """
    site = Site(render)
    out, hint = out.resolve(), "Name a new or empty folder with --out."
    scratch, digest = f".{out.name}-new-", hashlib.sha256(os.fsencode(out)).hexdigest()
    lock = Path(tempfile.gettempdir()) / f"gym-extensions-site-{digest[:16]}.lock"
    gc.disable()  # it would search all submissions again and again
    try:
        is_site = (out / paths.INDEX_DATA).is_file()
        if out.exists() and not is_site and (not out.is_dir() or any(out.iterdir())):
            raise BenchError("not-a-site", "It exists and does not contain a built site.", str(out), hint)
        out.parent.mkdir(parents=True, exist_ok=True)
        with FileLock(lock, timeout=0):
            for left in out.parent.glob(f"{scratch}*"):  # of a build that was killed
                shutil.rmtree(left)
            with tempfile.TemporaryDirectory(prefix=scratch, dir=out.parent) as folder:
                new, old = Path(folder) / "new", Path(folder) / "old"
                for number, (path, content) in enumerate(site.files(cards)):
                    if number % COLLECTED_FILES == 0:
                        gc.collect(1)
                    file = new / path
                    file.parent.mkdir(parents=True, exist_ok=True)
                    file.write_bytes(content.encode() if isinstance(content, str) else content)
                if out.exists():
                    out.rename(old)
                try:
                    new.rename(out)
                except BaseException:
                    if old.exists():
                        old.rename(out)
                    raise
    except Timeout as busy:
        raise BenchError(
            "two-writers", "Another process builds it.", str(out), "Wait until it ends."
        ) from busy
    except OSError as error:
        raise BenchError("no-folder", f"{error.strerror or error}.", str(out), hint) from error
    finally:
        gc.enable()
    return site.leaderboard

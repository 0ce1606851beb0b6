"""Builds the site from scorecards. The same scorecards give the same bytes.

Scorecards are read one after another: the files of a submission are written from its whole scorecard, and the
pages that show many submissions are written at the end, from what ``shortened`` keeps of each.
"""

from __future__ import annotations

import gc
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from gym_extensions.errors import BenchError
from gym_extensions.scoring.scorecard import ReferencesInfo, Scorecard
from gym_extensions.site import FOLDER
from gym_extensions.site.board_views import Leaderboard, shortened
from gym_extensions.site.output import Output, digest, encoded, kept_path
from gym_extensions.site.pages import PAGES
from gym_extensions.site.pages.page import Draft, File, Render
from gym_extensions.site.play.mujoco_wasm import Simulator
from gym_extensions.site.templating import source_digest

COLLECTED_FILES = 500
"""Number of files after which unused objects of their pages are removed from memory."""


@dataclass
class Site:
    """The files of a site, as its scorecards come."""

    render: Render
    keys: Mapping[str, str] = field(default_factory=dict)
    cards: dict[str, Scorecard] = field(default_factory=dict)

    @cached_property
    def leaderboard(self) -> Leaderboard:
        """All submissions and their boards. No submission may follow."""
        cards = tuple(self.cards[name] for name in sorted(self.cards))
        return Leaderboard(self.render.references, cards, self.render.inputs)

    def files(self, cards: Iterable[Scorecard]) -> Iterator[File]:
        """Every file: those of each submission as it comes, then those that are made from all submissions.

        Raises ``BenchError`` if a submission has the name of one before it.
        """
        for card in cards:
            if card.name in self.cards:
                hint = "Rename one of the folders."
                raise BenchError("same-name", f"Two submissions have the name {card.name!r}.", hint=hint)
            self.render.inputs[card.name] = digest(encoded(card)).encode()
            for page in self.render.pages:
                yield from page.publish_submission(card, self.render) if page.publish_submission else ()
            yield kept_path(card.name), encoded((self.keys.get(card.name, ""), card))
            self.cards[card.name] = shortened(card)
        for page in self.render.pages:
            yield from page.publish(self.leaderboard, self.render) if page.publish else ()
        for file in sorted((FOLDER / "static").rglob("*.*")):
            yield file.relative_to(FOLDER).as_posix(), file.read_bytes()


@dataclass(frozen=True)
class Built:
    """A site that was written: the path of its index, its leaderboard, and how many files are new."""

    index: Path
    leaderboard: Leaderboard
    written: int


def base_digest(references: ReferencesInfo) -> str:
    """A digest of what all pages depend on: the code, the libraries and the references."""
    return digest(source_digest().encode(), repr(references).encode())


def build_site(
    cards: Iterable[Scorecard],
    references: ReferencesInfo,
    out: Path,
    *,
    keys: Mapping[str, str] | None = None,
    folders: Mapping[str, Path] | None = None,
    simulator: Simulator | None = None,
    docs: bool = False,
) -> Built:
    """Writes the site to ``out``; a failed build leaves ``out`` unchanged.

    Files whose inputs did not change since the last build are kept.

    Args:
        cards: scorecards, which may come from a generator: only one is in memory at a time.
        references: the references that normalize all of them.
        out: the folder.
        keys: by submission, the key under which its scorecard is kept for the next build.
        folders: by submission, its folder, whose poses Watch panels show; poses of other results are not
            shown.
        simulator: MuJoCo for the browser; without it the page Play says that it is missing.
        docs: whether pages link to the documentation in ``out/docs``, which is built afterwards.

    Raises:
        BenchError: ``out`` exists, is not empty, and was not written by an earlier build, or two submissions
            have the same name.
    """
    render = Render(references, PAGES, folders or {}, simulator, docs)
    site = Site(render, keys or {})
    gc.disable()  # it would search all submissions again and again
    try:
        with Output(out, f"{base_digest(references)} {docs}") as output:
            for number, (path, content) in enumerate(site.files(cards)):
                if number % COLLECTED_FILES == 0:
                    gc.collect(1)
                if isinstance(content, Draft):
                    output.add_draft(path, content.inputs, content.write)
                else:
                    output.add(path, content.encode() if isinstance(content, str) else content)
    finally:
        gc.enable()
    return Built(out / "index.html", site.leaderboard, output.written)

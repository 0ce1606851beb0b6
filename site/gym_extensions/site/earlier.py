"""The scorecards of an earlier build, for submissions whose files did not change since.

Scoring a submission takes half a second, reading its scorecard a few milliseconds. A build keeps every
scorecard in a hidden folder of the site. The JSON in ``api/`` would not do: its keys are sorted, so the order
of a manifest is lost.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath

import msgspec

from gym_extensions.curation.digest import folder_digest
from gym_extensions.curation.ledger.apply import ledger_record
from gym_extensions.curation.ledger.chain import read, states
from gym_extensions.rollouts.folder import scan
from gym_extensions.scoring.pipeline.score import Scorer, scorecards
from gym_extensions.scoring.reevaluation.record import with_returns
from gym_extensions.scoring.repetition.record import FOLDER, path_of
from gym_extensions.scoring.scorecard.model import REPORTED, VALIDATED, Scorecard
from gym_extensions.site.addresses import slug
from gym_extensions.site.output import digest

Kept = tuple[str, Scorecard]
"""The key of a scorecard (``EarlierSite.key``), and the scorecard."""


def kept_path(name: str) -> str:
    """The path in the site of the kept scorecard of a submission."""
    return f".scorecards/{slug(name)}"


def kept(key: str, card: Scorecard) -> bytes:
    """The content of that file; empty if the scorecard has a whole number of more than 64 bits."""
    try:
        return msgspec.msgpack.encode((key, card))
    except OverflowError:
        return b""


def has_only_files(folder: Path) -> bool:
    """Whether a submission has only files and folders with files: nothing that its digest leaves out."""
    submission = scan(folder)
    parents = {str(parent) for path in submission.files for parent in PurePosixPath(path).parents}
    return all(item.kind == "file" or item.path in parents for item in submission.items)


class EarlierSite:
    """A site that was built before, or a folder without one.

    Args:
        out: the folder.
        base: the digest of what all pages depend on.
    """

    def __init__(self, out: Path, base: str) -> None:
        self.out = out
        self.base = base
        self.folder_digest = functools.cache(folder_digest)
        self.key = functools.cache(self._key)
        self._states = functools.cache(lambda root: states(read(root)))

    def _key(self, folder: Path) -> str:
        """The digest of what the scorecard of a submission depends on beside its files.

        It is made from the base and from what may replace missing traces: the record of a repetition, and
        whether the ledger says that all episodes were replayed.

        Raises:
            BenchError: a ledger is broken.
        """
        root, name = folder.resolve().parent, folder.resolve().name
        record = path_of(root.parent / FOLDER, name)
        state = self._states(root).get(name)
        is_complete = state is not None and ledger_record(state.last.digest, state).is_complete
        content = record.read_bytes() if record.is_file() else b""
        return digest(self.base.encode(), content, str(is_complete).encode())

    def scorecards(self, folders: Sequence[Path], scorer: Scorer) -> Iterator[Scorecard]:
        """The scorecards of submissions in the order of their folders. Only changed ones are scored."""
        changed = [folder for folder in folders if self.scorecard(folder) is None]
        scored = scorecards(changed, scorer)
        is_changed = set(changed).__contains__
        for folder in folders:
            yield next(scored) if is_changed(folder) else self.scorecard(folder) or scorer(folder)

    def scorecard(self, folder: Path) -> Scorecard | None:
        """The scorecard of a submission as the scorer returns it, without what the ledger says.

        None if the earlier site does not have it, if the submission was refused or not in a ledger, or if
        the submission or its key changed.
        """
        card = self._kept(folder)
        if card is None or card.problems or card.ledger is None:
            return None
        try:
            if not has_only_files(folder) or card.ledger.digest != self.folder_digest(folder):
                return None
        except OSError:  # a file that cannot be read; the scorer reports it
            return None
        return replace(
            card,
            trust=REPORTED if card.trust == REPORTED else VALIDATED,
            new_seeds=None,
            ledger=None,
            challenges=(),
            groups=with_returns(card.groups, {}),
        )

    def _kept(self, folder: Path) -> Scorecard | None:
        """The scorecard that the earlier build kept, if it was made with the same key."""
        try:
            content = (self.out / kept_path(folder.name)).read_bytes()
            key, card = msgspec.msgpack.decode(content, type=Kept)
        except (OSError, ValueError):
            return None
        return card if key == self.key(folder) else None

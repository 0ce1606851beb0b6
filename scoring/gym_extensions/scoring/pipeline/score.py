"""Folders of submissions -> the scorecard, a JSON document described key by key in docs/scorecard.md."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gym_extensions.rollouts.folder import submission_folders
from gym_extensions.scoring.output.json import text
from gym_extensions.scoring.pipeline.batch import Work, cards
from gym_extensions.scoring.references import References, load_references

FORMAT = 1

Document = dict[str, Any]

__all__ = ["Document", "document", "score_folder", "score_folders", "text"]


def document(cards: Sequence[Document], references: References) -> Document:
    """The whole document around the scorecards."""
    return {
        "format": FORMAT,
        "references": {
            "version": references.version,
            "provisional": references.provisional,
            "sha256": references.digest,
        },
        "submissions": list(cards),
    }


def score_folders(
    folders: Sequence[Path], references: References | None = None, cache: Path | None = None
) -> Document:
    """The JSON document of all submissions in the folders, sorted by name.

    Args:
        folders: submissions, or folders that hold submissions.
        references: floors and ceilings; the current benchmark version's where None.
        cache: a folder where scorecards are kept by content, so that only what has changed is scored.
    """
    known = load_references() if references is None else references
    found = submission_folders(list(folders))
    return document(list(cards(found, Work(known, cache))), known)


def score_folder(path: Path, references: References | None = None) -> Document:
    """The scorecard of the one submission in a folder."""
    return Work(load_references() if references is None else references)(path)

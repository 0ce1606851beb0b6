"""Documents: the same value after writing and reading, no NaN, and keys of other versions."""

import math
from dataclasses import replace

import pytest

from gym_extensions.references import References
from gym_extensions.scoring.pipeline import score_folders
from gym_extensions.scoring.ranking.boards import BoardsDocument
from gym_extensions.scoring.ranking.group_board import boards
from gym_extensions.scoring.scorecard import ScorecardDocument

from ..conftest import write_submission
from .made_submissions import Enter


@pytest.fixture(scope="module")
def document(tmp_path_factory: pytest.TempPathFactory, references: References) -> ScorecardDocument:
    folder = tmp_path_factory.mktemp("document")
    folder = write_submission(folder, curves=12, protocols=("sequential", "single", "joint"))
    return score_folders([folder], references)


def test_boards_are_the_same_after_writing_and_reading(enter: Enter) -> None:
    document = boards([enter("a", 300), enter("b", 301)])
    assert document.boards[0].rows[0].vs_next is not None
    assert BoardsDocument.from_json(document.to_json()) == document


def test_a_number_that_is_not_finite_is_never_written(document: ScorecardDocument) -> None:
    (card,) = document.submissions
    score = replace(card.groups["hopper-gravity-v0"]["sequential"], iqm=math.inf)
    broken = replace(card, groups={"hopper-gravity-v0": {"sequential": score}})
    with pytest.raises(ValueError, match="Out of range float values are not JSON compliant"):
        replace(document, submissions=(broken,)).to_json()


def test_an_absent_key_is_written_and_one_of_a_later_version_is_ignored(document: ScorecardDocument) -> None:
    text = document.to_json()
    read = ScorecardDocument.from_json(text.replace('"notes": [],', ""))
    assert text.count('"notes": [],') > 1
    assert read == document
    assert read.to_json() == text
    later = text.replace('"format": 1,', '"format": 1, "later": true,', 1)
    assert ScorecardDocument.from_json(later) == document

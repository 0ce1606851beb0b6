"""Many submissions at once: the same document in any order and place, and an error stops no other."""

from pathlib import Path
from typing import Any

import pytest

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.tasks import Task
from gym_extensions.references import References, path_of
from gym_extensions.scoring.pipeline import Scorer, make_scorer, score_folders, scorecard_document, scorecards
from gym_extensions.submissions import reader
from gym_extensions.submissions.layout import submission_folders
from gym_extensions.submissions.reader import read

from ..conftest import Write, refused


@pytest.fixture
def many(make_submission: Write) -> Path:
    """A folder of three submissions, one of them broken."""
    for name in ("b", "a", "c"):
        folder = make_submission(name=f"all/{name}", curves=12, protocols=("sequential", "single", "joint"))
    (folder / "notes.txt").write_text("")
    return folder.parent


def test_an_unforeseen_error_is_a_problem_of_that_submission_alone(
    make_submission: Write, references: References, monkeypatch: pytest.MonkeyPatch
) -> None:
    folders = [make_submission(name=name) for name in "ab"]

    def failing(path: Path, *arguments: Any, **options: Any) -> object:
        if path.name == "a":
            raise ZeroDivisionError
        return read(path, *arguments, **options)

    monkeypatch.setattr(reader, "read", failing)
    broken, good = scorecards(folders, Scorer(references), workers=1)
    (problem,) = broken.problems
    assert (problem.rule, problem.where) == ("fault-of-the-scorer", "a")
    assert "ZeroDivisionError" in problem.message
    assert "please report it" in problem.hint
    assert good.level == "claimed"


def test_the_path_and_the_order_of_folders_do_not_matter(many: Path, references: References) -> None:
    folders = submission_folders([many])
    whole = score_folders(folders, references).to_json()
    assert score_folders(folders[::-1], references).to_json() == whole
    assert score_folders([many], references).to_json() == whole
    moved = many.rename(many.with_name("elsewhere"))
    assert score_folders([moved], references).to_json() == whole
    assert str(moved.parent) not in whole


def test_workers_do_not_matter(many: Path, references: References) -> None:
    folders = submission_folders([many])
    one, two = (
        scorecard_document(list(scorecards(folders, Scorer(references), workers)), references).to_json()
        for workers in (1, 2)
    )
    assert one == two


def test_every_task_of_a_custom_group_needs_a_reference() -> None:
    group = TaskGroup("mine", (Task("MyHopper", "Hopper"),))
    path = path_of("1")
    with refused("missing-reference", "MyHopper", where=str(path)):
        make_scorer([group], path)

"""The command ``score``, and scorecards of made-up submissions, each scored once."""

import pytest

from gym_extensions.references import References
from gym_extensions.scoring import cli
from gym_extensions.scoring.pipeline import score_folder
from gym_extensions.scoring.scorecard import Scorecard

from ..conftest import MANIFEST, Value, Write
from .made_submissions import FIVE, Command, Enter, Shown


@pytest.fixture(scope="session")
def cards() -> dict[object, Scorecard]:
    """The scorecards of these tests, which never change, by how they were made."""
    return {}


@pytest.fixture
def enter(make_submission: Write, references: References, cards: dict[object, Scorecard]) -> Enter:
    def make(
        name: str,
        level: float,
        *,
        runs: tuple[int, ...] = FIVE,
        task_conditioned: bool = False,
        protocols: tuple[str, ...] = ("sequential",),
        value: Value | None = None,
    ) -> Scorecard:
        key = (name, level, runs, task_conditioned, protocols, value)
        if key in cards:
            return cards[key]
        manifest = MANIFEST.replace('"smoke"', '"100k"')
        if task_conditioned:
            manifest = manifest.replace("task_in_evaluation = false", "task_in_evaluation = true")

        def around_level(protocol: str, run: int, stage: int, position: int, episode: int) -> float:
            return stage * level / 5 + 10.0 * (run * 3 % 5) + position - episode / 20

        folder = make_submission(
            name=name, runs=runs, manifest=manifest, protocols=protocols, value=value or around_level
        )
        cards[key] = score_folder(folder, references)
        return cards[key]

    return make


@pytest.fixture
def score(known: None, capsys: pytest.CaptureFixture[str]) -> Command:
    """Runs the command with the synthetic references."""

    def run(*arguments: object) -> Shown:
        status = cli.main([*map(str, arguments)])
        return Shown(status, *capsys.readouterr())

    return run

"""A run of a reference agent is trained again: the same bytes, another log, and agents of strangers."""

import shutil
from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

import msgspec
import pytest

from gym_extensions.baselines import train
from gym_extensions.catalog.groups import TaskGroup, with_custom
from gym_extensions.envs.rollout import Outcome
from gym_extensions.submissions import reader
from gym_extensions.submissions.layout import Folder, scan
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.review import NEW_SEEDS_ALPHA, read_review
from gym_extensions.submissions.run import read_run
from gym_extensions.verification import retrain
from gym_extensions.verification.logged_run import logged_runs
from gym_extensions.verification.retrain import Cells, compare_cells, drawn_run, train_again

from ..baselines.conftest import QUICK_TOML
from ..submissions.examples import TOML, Change, edit
from . import made_submissions as submissions
from .made_submissions import VALUE, change_document

RUN = "quick-pusher/sequential/run0"


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a custom group and one run of two agents: one repeats its actions, the other samples."""
    folder = tmp_path_factory.mktemp("trained")
    (folder / "quick.toml").write_text(QUICK_TOML, encoding="utf-8")
    for agent in ("trpo", "random"):
        train(agent, folder / "quick.toml", "sequential", "smoke", 0, out=folder / agent)
    return folder


@pytest.fixture
def workshop(made: Path, tmp_path: Path, in_this_process: None) -> Path:
    """A copy of that folder that may be changed."""
    return Path(shutil.copytree(made, tmp_path / "submissions"))


def verify(submission: Path, *options: str) -> int:
    return submissions.verify(
        submission, "--retrain", "--groups", str(submission.parent / "quick.toml"), *options
    )


def level_of(submission: Path) -> str:
    return submissions.level_of(submission, with_custom([submission.parent / "quick.toml"]))


def multiply(submission: Path, factor: float) -> None:
    """Multiplies the logged returns before training."""
    submissions.change_log(submission, lambda row: {"return": row["return"] * factor ** (row["stage"] == 0)})


@pytest.mark.parametrize("agent", ["trpo", "random"])
def test_a_run_with_the_same_bytes_is_reproduced_and_the_submission_is_read_once(
    workshop: Path, agent: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    scanned: list[Path] = []

    def scanning(path: Path, groups: Mapping[str, TaskGroup]) -> Folder:
        scanned.append(path)
        return scan(path, groups)

    monkeypatch.setattr(reader, "scan", scanning)
    assert verify(workshop / agent, "--write") == 0
    assert scanned == [workshop / agent]
    assert f"trained again: {RUN}: the same episodes" in capsys.readouterr().out
    (record,) = read_review(workshop / agent).verifications
    assert record.passed
    assert record.retrained == [RUN]
    assert level_of(workshop / agent) == "verified"


def test_a_log_that_its_policies_give_and_its_training_does_not_is_refuted(
    workshop: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    submission = workshop / "random"
    other = Path(shutil.copytree(submission, workshop / "other"))
    multiply(other, 0.5)
    monkeypatch.setattr(retrain, "retrain", lambda *_: other / f"{RUN}.csv")
    assert verify(submission, "--write") == 1
    assert "means differ after training again" in capsys.readouterr().out
    (record,) = read_review(submission).verifications
    assert (record.difference.startswith(RUN), record.passed, record.retrained) == (True, False, [])
    assert record.p_value > NEW_SEEDS_ALPHA
    assert level_of(submission) == "claimed"


def test_another_log_within_noise_is_not_reproduced_on_the_machine_that_made_it(
    workshop: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    submission = workshop / "random"
    multiply(submission, 1 - 1e-9)
    assert verify(submission, "--write") == 0
    assert "NOT the same episodes" in capsys.readouterr().out
    assert level_of(submission) == "verified"


def test_a_run_that_was_made_elsewhere_is_compared_by_its_means(
    workshop: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    submission = workshop / "random"
    multiply(submission, 1 - 1e-9)
    document = submission / f"{RUN}.json"
    versions = msgspec.structs.replace(read_run(document).versions, gym_extensions="0.9.0")
    change_document(document, versions=versions)
    assert verify(submission, "--write") == 0
    assert "means within noise" in capsys.readouterr().out
    assert read_review(submission).verifications[0].retrained
    assert level_of(submission) == "verified"


REFUSED: dict[str, tuple[str, Change, str]] = {
    "a stranger's agent": ("random", edit('"random"', '"mine"', TOML), "'mine' is not a reference agent."),
    "a module": ("random", edit('"random"', '"os:system"', TOML), "is not a reference agent"),
    "a setting of no agent": ("trpo", edit("max_kl = 0.04", "max_kl = 0.5", TOML), "max_kl"),
    "policies from elsewhere": (
        *("random", lambda submission: change_document(submission / f"{RUN}.json", steps_counted=False)),
        "trained elsewhere",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_trained_again_is_refused(
    workshop: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    agent, change, message = REFUSED[name]
    change(workshop / agent)
    assert verify(workshop / agent, "--write") == 2
    out, said = capsys.readouterr()
    assert (out, message in said) == ("", True)
    assert not (workshop / agent / "review.toml").exists()
    if agent == "random":  # settings are tried when the agent is made
        assert not [*(workshop / "cache").glob("*")], "nothing was run"


def test_training_is_tried_with_one_thread_and_with_all(
    workshop: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Large matrix products have other last bits then, and no document says which it was."""
    submission = workshop / "random"
    tried: list[int] = []
    other = Path(shutil.copytree(submission, workshop / "other"))
    multiply(other, 0.5)

    def trained(*_: object, **__: object) -> Path:
        return (other if len(tried) == 1 else submission) / f"{RUN}.csv"

    def limits(threads: int) -> AbstractContextManager[None]:
        tried.append(threads)
        return nullcontext()

    monkeypatch.setattr(retrain, "threadpool_info", lambda: [{"num_threads": 1}, {"num_threads": 8}])
    monkeypatch.setattr(retrain, "threadpool_limits", limits)
    monkeypatch.setattr(retrain, "retrain", trained)
    found = read(submission, with_custom([workshop / "quick.toml"]))
    assert train_again(logged_runs(found)[RUN]).is_same
    assert tried == [1, 8]


def cells_of(*returns: float) -> Cells:
    """One cell."""
    return {(1, 0): [Outcome(10, value, False, None) for value in returns]}


def test_cells_without_variance_or_without_episodes_agree_only_if_they_are_equal() -> None:
    constant = cells_of(*[1.0] * 20)
    assert compare_cells(constant, constant).is_same
    other = compare_cells(constant, cells_of(*[1.0 + 1e-12] * 20))
    assert (other.is_same, other.differing) == (False, 1)
    missing = compare_cells(constant, constant | {(2, 0): constant[1, 0]})
    assert (missing.differing, missing.cells) == (1, 2)


def test_the_value_draws_the_run() -> None:
    names = [f"pusher/joint/run{run}" for run in range(5)]
    drawn = {drawn_run(names, f"{value:040x}") for value in range(50)}
    assert drawn == set(names)
    assert drawn_run(reversed(names), VALUE) == drawn_run(names, VALUE)

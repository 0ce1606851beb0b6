"""A run has all traces of its sample or none; runs without traces are not replayed."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from gym_extensions.baselines import train
from gym_extensions.baselines.tracing.trace import trace
from gym_extensions.curation.evidence import prove
from gym_extensions.scoring import score_folder
from gym_extensions.scoring.replay.verify import verified, verify

GROUP = "pusher"
SALT = "5a" * 32
EPISODES = [f"single-run2-stage1-Pusher-episode{number}.npz" for number in range(20)]


@pytest.fixture(scope="module")
def honest(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three runs of two tasks in two protocols, with the traces of the sample of a salt."""
    folder = tmp_path_factory.mktemp("submissions") / "honest"
    train("random", GROUP, ["single", "joint"], "smoke", range(3), out=folder, progress=False)
    trace(folder, SALT)
    return folder


@pytest.fixture
def copy(honest: Path, tmp_path: Path) -> Path:
    ignore = shutil.ignore_patterns(".progress")
    return Path(shutil.copytree(honest, tmp_path / "copy", ignore=ignore))


def remove(folder: Path, pattern: str) -> int:
    """Removes traces and returns their number."""
    paths = sorted((folder / GROUP / "traces").glob(pattern))
    for path in paths:
        path.unlink()
    return len(paths)


def test_a_run_without_traces_is_not_replayed(copy: Path) -> None:
    whole = verify(copy)
    removed = remove(copy, "single-run2-*")
    part = verify(copy)
    assert removed > 0
    assert (part.problems, part.replayed) == ((), whole.replayed - removed)
    assert part.level == f"replayed (salted sample: {part.replayed} of 240 episodes)"


def test_the_entry_then_lacks_evidence_for_a_rank(copy: Path) -> None:
    removed = remove(copy, "single-run2-*")
    scores = score_folder(copy).groups[f"{GROUP}-v0"]
    total = removed + len(list((copy / GROUP / "traces").glob("single-*")))
    message = f"{removed} of {total} traces of the audit sample are missing."
    assert (scores["single"].missing_evidence, scores["joint"].missing_evidence) == (message, "")


def test_a_run_that_lacks_some_of_its_traces_is_a_problem(copy: Path) -> None:
    first, *_ = sorted((copy / GROUP / "traces").glob("single-run2-*"))
    first.unlink()
    (problem,) = verify(copy).problems
    assert (problem.rule, problem.where) == ("trace-missing", f"{GROUP}/traces/{first.name}")


def test_a_trace_of_another_episode_does_not_stand_for_the_sample(copy: Path) -> None:
    sample = {path.name: path.read_bytes() for path in (copy / GROUP / "traces").glob("single-run2-*")}
    data = next(iter(sample.values()))
    removed = remove(copy, "single-run2-*")
    name = next(name for name in EPISODES if name not in sample)
    (copy / GROUP / "traces" / name).write_bytes(data)
    problems = verify(copy).problems
    assert len(problems) == removed
    assert {problem.rule for problem in problems} == {"trace-missing"}


def test_no_salt_is_asked_of_a_log_without_traces(copy: Path) -> None:
    remove(copy, "*.npz")
    (copy / GROUP / "traces" / "salt.txt").unlink()
    assert verify(copy, salt="b7" * 32).problems == ()


def test_an_entry_of_which_one_log_has_no_traces_is_not_replayed(copy: Path) -> None:
    remove(copy, "joint-*")
    verification = verify(copy)
    assert (verification.problems, verification.level) == ((), "validated")
    assert verification.replayed > 0
    card = verified(score_folder(copy), copy)
    assert card.trust == "validated"
    assert card.notes[-1] == "Not all of its logs have traces: the others were not replayed."
    evidence = prove(copy, SALT)
    assert (evidence.level, evidence.replayed) == ("validated", 0)

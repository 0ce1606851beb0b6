"""Repetition: the stored policies give every logged episode again, and any other row is named."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from gym_extensions.baselines import train
from gym_extensions.envs import fingerprint
from gym_extensions.errors import BenchError
from gym_extensions.installed import blas_kernels
from gym_extensions.rollouts.folder import scan
from gym_extensions.rollouts.policies import Policy
from gym_extensions.scoring.repetition.cli import main
from gym_extensions.scoring.repetition.digests import RunKey, run_digests
from gym_extensions.scoring.repetition.record import RepeatedRun, RepetitionRecord, load, path_of, write
from gym_extensions.scoring.repetition.repeat import read_submission
from gym_extensions.scoring.repetition.runs import repeat

GROUP, NAME = "pusher-v0", "trpo"
RUNS = [RunKey(GROUP, "single", 0), RunKey(GROUP, "single", 1)]
Row = dict[str, str]


@pytest.fixture(scope="module")
def honest(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A deterministic agent with policies: two runs of two tasks, 40 episodes each."""
    folder = tmp_path_factory.mktemp("submissions") / NAME
    train("trpo", "pusher", "single", "smoke", [0, 1], out=folder, progress=False)
    shutil.rmtree(folder / ".progress")
    return folder


@pytest.fixture
def copy(honest: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(honest, tmp_path / NAME))


def digests(folder: Path) -> dict[RunKey, str]:
    return run_digests(read_submission(folder), scan(folder))


def edit_row(folder: Path, index: int, change: Callable[[Row], Mapping[str, str]]) -> None:
    """Changes cells of a row of the log."""
    log = folder / "pusher" / "single.csv"
    header, *rows = (line.split(",") for line in log.read_text().splitlines())
    row = dict(zip(header, rows[index], strict=True))
    rows[index] = list({**row, **change(row)}.values())
    log.write_text("".join(",".join(cells) + "\n" for cells in (header, *rows)), newline="\n")


def test_every_episode_of_an_honest_log_is_repeated(honest: Path) -> None:
    results = list(repeat(honest))
    assert [(each.key, each.episodes, each.difference) for each in results] == [
        (RUNS[0], 40, ""),
        (RUNS[1], 40, ""),
    ]


def test_the_command_writes_a_record_that_covers_the_submission(
    honest: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(honest), "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "pusher-v0 single run 0: 40 episodes are repeated",
        "pusher-v0 single run 1: 40 episodes are repeated",
        "trpo: all 80 episodes are repeated.",
    ]
    record = load(tmp_path, NAME)
    assert record is not None and record.covers(digests(honest))
    assert record.submission == NAME
    assert [(each.key, each.episodes, each.blas, each.digest) for each in record.runs] == [
        (key, 40, blas_kernels(), digests(honest)[key]) for key in RUNS
    ]


def test_a_second_call_repeats_only_what_the_record_lacks(
    honest: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first = RepeatedRun(GROUP, "single", 0, 40, "openblas Itanium", digests(honest)[RUNS[0]])
    write(tmp_path, RepetitionRecord(submission=NAME, runs=(first,)))
    assert main([str(honest), "--out", str(tmp_path)]) == 0
    assert "run 0" not in capsys.readouterr().out
    record = load(tmp_path, NAME)
    assert record is not None
    assert [each.blas for each in record.runs] == ["openblas Itanium", blas_kernels()]


def test_runs_with_other_rows_or_policies_are_replaced(honest: Path, tmp_path: Path) -> None:
    others = (
        RepeatedRun(GROUP, "joint", 7, 40, "openblas Itanium", "0" * 64),
        RepeatedRun(GROUP, "single", 0, 40, "openblas Itanium", "0" * 64),
    )
    write(tmp_path, RepetitionRecord(submission=NAME, runs=others))
    assert main([str(honest), "--out", str(tmp_path)]) == 0
    record = load(tmp_path, NAME)
    assert record is not None and [each.key for each in record.runs] == RUNS


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda row: {"return": repr(float(row["return"]) * (1 + 1e-15))}, "return .* in the log, return"),
        (lambda row: {"success": "true"}, "success True in the log, .* success False here"),
    ],
)
def test_a_changed_row_is_named_and_its_run_is_not_recorded(
    copy: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    change: Callable[[Row], Mapping[str, str]],
    message: str,
) -> None:
    edit_row(copy, 25, change)
    assert main([str(copy), "--out", str(tmp_path / "out")]) == 1
    first, second, last = capsys.readouterr().out.splitlines()
    task = r"pusher-v0 single run 0: differs at stage 1, PusherMovingGoal, episode 5: "
    assert re.match(f"{task}.*{message}", first)
    assert second == "pusher-v0 single run 1: 40 episodes are repeated"
    assert last == "trpo: some runs are not repeated. The BLAS kernels are those of the log."
    record = load(tmp_path / "out", NAME)
    assert record is not None
    assert [each.key for each in record.runs] == RUNS[1:]
    assert not record.covers(digests(copy))


def test_the_policy_of_another_run_gives_other_episodes(copy: Path) -> None:
    policies = copy / "pusher" / "policies"
    shutil.copy(policies / "single-run1-stage1-Pusher.npz", policies / "single-run0-stage1-Pusher.npz")
    first, second = repeat(copy)
    assert first.difference.startswith("stage 1, Pusher, episode 0: return ")
    assert not second.difference


def test_a_policy_that_cannot_act_is_a_difference(copy: Path) -> None:
    policy = Policy.from_bytes((copy / "pusher/policies/single-run0-stage1-Pusher.npz").read_bytes())
    arrays = policy.arrays()
    arrays["weight_0"] = arrays["weight_0"][1:]
    for name in ("observation_mean", "observation_scale"):
        arrays[name] = arrays[name][1:]
    for path in (copy / "pusher" / "policies").iterdir():
        path.write_bytes(Policy.from_arrays(arrays).to_bytes())
    first, _ = repeat(copy)
    assert "the policy has 22 inputs" in first.difference


def test_a_log_without_policies_is_not_covered(
    copy: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.rmtree(copy / "pusher" / "policies")
    assert main([str(copy), "--out", str(tmp_path / "out")]) == 1
    assert "Some logs have no policies" in capsys.readouterr().out
    assert not (tmp_path / "out").exists()


def test_a_digest_is_that_of_the_rows_and_policies_of_one_run(honest: Path, copy: Path) -> None:
    rows = (copy / "pusher" / "single.csv").read_bytes().splitlines(keepends=True)[1:41]
    names = ("single-run0-stage1-Pusher.npz", "single-run0-stage1-PusherMovingGoal.npz")
    files = [b"".join(rows), *((copy / "pusher" / "policies" / name).read_bytes() for name in names)]
    text = "".join(f"{hashlib.sha256(data).hexdigest()}\n" for data in files)
    assert digests(copy)[RUNS[0]] == hashlib.sha256(text.encode()).hexdigest()
    edit_row(copy, 45, lambda row: {"return": repr(float(row["return"]) + 1)})
    after, before = digests(copy), digests(honest)
    assert after[RUNS[0]] == before[RUNS[0]]
    assert after[RUNS[1]] != before[RUNS[1]]


def test_a_row_whose_run_has_a_leading_zero_is_a_row_of_that_run(copy: Path) -> None:
    edit_row(copy, 3, lambda _: {"run": "00"})
    before = digests(copy)
    edit_row(copy, 3, lambda row: {"return": repr(1.5 * float(row["return"]))})
    after = digests(copy)
    assert before.keys() == after.keys()
    assert before[RUNS[0]] != after[RUNS[0]]


@pytest.mark.parametrize(("recorded", "covers"), [("ab", True), ("aa", False), ("a", False), ("", False)])
def test_a_record_covers_a_submission_if_it_has_every_run(recorded: str, covers: bool) -> None:
    runs = tuple(RepeatedRun(GROUP, "single", run, 40, "x", digest) for run, digest in enumerate(recorded))
    assert RepetitionRecord(submission=NAME, runs=runs).covers(dict(zip(RUNS, "ab", strict=True))) is covers


def test_a_run_without_policies_is_never_covered() -> None:
    runs = (RepeatedRun(GROUP, "single", 0, 40, "x", ""),)
    record = RepetitionRecord(submission=NAME, runs=runs)
    assert not record.covers({RUNS[0]: ""})
    assert not record.covers({})


def test_sampled_actions_cannot_be_repeated(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "random"
    train("random", "pusher", "single", "smoke", 0, out=folder, progress=False)
    assert main([str(folder), "--out", str(tmp_path / "out")]) == 2
    assert "Its policies sample their actions, so that their episodes cannot be repeated." in (
        capsys.readouterr().err
    )


def test_a_submission_with_problems_is_refused(copy: Path) -> None:
    (copy / "notes.txt").write_text("x")
    with pytest.raises(BenchError, match="Unexpected"):
        list(repeat(copy))


def test_another_engine_is_refused(honest: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fingerprint, "engine", lambda: {"mujoco": "3.17.0", "gymnasium": "1.4.0"})
    with pytest.raises(BenchError, match="3\\.17\\.0"):
        next(repeat(honest))


def test_a_file_that_is_not_a_record_is_named(
    honest: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path_of(tmp_path, NAME).write_text(json.dumps({"format": 2}))
    assert main([str(honest), "--out", str(tmp_path)]) == 2
    assert "gym-extensions repeat" in capsys.readouterr().err

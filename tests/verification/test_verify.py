"""A submission is verified: its episodes are repeated, its policies run on new seeds, and that decides."""

import math
import os
import platform
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.curation.cli import maintain
from gym_extensions.envs import fingerprinting, make
from gym_extensions.errors import BenchError
from gym_extensions.submissions import review
from gym_extensions.submissions.fetch import Fetcher
from gym_extensions.submissions.log import read_log
from gym_extensions.submissions.policies.files import policy_keys, read_policies
from gym_extensions.submissions.policies.mlp import Policy
from gym_extensions.submissions.poses import load_submission
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.review import Review, Verification, read_review, why_claimed, write_review
from gym_extensions.submissions.run import Machine, read_run
from gym_extensions.submissions.submission import Submission
from gym_extensions.verification import after_merge, cli as verification_cli, episodes, limits
from gym_extensions.verification.cli import main
from gym_extensions.verification.logged_run import logged_runs
from gym_extensions.verification.verify import Report, verify as verify_submission
from gym_extensions.versions import processor

from ..submissions.policies.specified import specified_action
from . import made_submissions as submissions
from .made_submissions import GROUP, VALUE, Row, change_log, copy, honest, level_of, verify

RUNS = 2
"""A rank needs five; a verification tests any number."""


@pytest.fixture(scope="module")
def verified(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An honest submission that was verified in a process with limits. It must not be changed."""
    submission = copy(honest(runs=RUNS), tmp_path_factory.mktemp("verified") / "mine")
    assert level_of(submission) == "claimed"
    assert verify(submission, "--write") == 0
    return submission


@pytest.fixture
def submission(tmp_path: Path, in_this_process: None) -> Path:
    """A copy of an honest submission whose deterministic policies run in this process, without limits."""
    return copy(honest(runs=RUNS), tmp_path / "mine")


def test_an_honest_submission_is_verified_and_the_record_says_what_was_done(
    verified: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    submission = verified
    (record,) = read_review(submission).verifications
    tasks = len(group(GROUP).tasks)
    assert (record.passed, record.value, record.difference) == (True, VALUE, "")
    assert (record.repeated, record.episodes) == (RUNS * (tasks + 1) * tasks * 20,) * 2
    assert record.cells == RUNS * (tasks + 1) * tasks
    assert sorted(record.runs) == [f"{GROUP}/sequential/run{run}" for run in range(RUNS)]
    assert level_of(submission) == "verified"
    assert load_submission(submission) == {}
    for line in (f"poses/{GROUP}.json: run 0.", "up to date."):
        assert maintain(["poses", str(submission)]) == 0
        assert line in capsys.readouterr().out
    (poses,) = load_submission(submission).values()
    (submitted,) = read(submission).groups.values()
    rows = submitted.logs["sequential"].rows.query("run == 0")
    means = rows["return"].to_numpy().reshape(tasks + 1, tasks, -1).mean(axis=2)
    assert poses.shows((0,), (tuple(map(tuple, means.tolist())),))


def test_without_seeds_nothing_is_recorded(submission: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(submission), "--cache", str(submission.parent / "cache")]) == 0
    assert "not stored" in capsys.readouterr().out
    assert main([str(submission), "--write"]) == 2, "it is in no commit"
    assert not (submission / "review.toml").exists()


def test_the_first_draw_stands_and_new_files_are_drawn_for_anew(
    submission: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    change_log(submission, lambda row: {"return": row["return"] * 1.5})
    assert verify(submission, "--write") == 1
    refused = (submission / "review.toml").read_bytes()
    assert verify(submission, "--write", "--seeds", "4f" * 20) == 1
    said = capsys.readouterr().out
    assert "no run with policies is left" in said
    assert "claimed: The verification of" in said
    assert (submission / "review.toml").read_bytes() == refused
    assert level_of(submission) == "claimed"
    submissions.change_documents(submission, lambda run: {"cpu_seconds": 1.0})
    manifest = submission / "submission.toml"
    manifest.write_text(manifest.read_text().replace("steps = 0", "steps = 1"))
    assert verify(submission, "--write", "--seeds", "4f" * 20) == 1
    assert "no run with policies is left" in capsys.readouterr().out, "documents and settings do not count"
    assert level_of(submission) == "claimed"
    change_log(submission, lambda row: {"return": row["return"] / 1.4}, run=1)
    assert verify(submission, "--write") == 1
    first, second = read_review(submission).verifications
    assert list(second.runs) == [f"{GROUP}/sequential/run1"]
    assert len(first.runs) == RUNS, "the refusal stays on record"


def test_an_episode_that_differs_is_named_with_its_place_and_size(
    submission: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place = {"stage": 1, "episode": 7, "task": group(GROUP).task_ids[1]}

    def lower(row: Row) -> Row:
        is_there = all(row[name] == value for name, value in place.items())
        return {"return": row["return"] - 0.25} if is_there else {}

    change_log(submission, lower, run=1)
    assert verify(submission) == 1
    out = capsys.readouterr().out
    assert f"{GROUP}/sequential/run1: stage 1, {group(GROUP).tasks[1].name}, episode 7" in out
    assert "difference 0.25" in out


def test_a_difference_on_another_platform_neither_raises_nor_lowers_the_level(
    submission: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    change_log(submission, lambda row: {"return": row["return"] - 1e-9}, run=1)
    monkeypatch.setattr(platform, "machine", lambda: "riscv64")
    assert verify(submission, "--write") == 0
    assert "This machine is Linux-riscv64" in capsys.readouterr().out
    (record,) = read_review(submission).verifications
    assert record.repeated < record.episodes
    assert "run1" in record.difference


@pytest.mark.parametrize(
    ("stated", "of_networks"),
    [
        ({}, ""),
        ({"versions": {"blas": "openblas Zen", "numpy": "1.0"}}, ""),
        ({"versions": {"platform": "Darwin-arm64"}}, "platform Darwin-arm64 / Linux-x86_64"),
        ({"packages": {"onnxruntime": "0.1"}}, "onnxruntime 0.1 / 1.32.0"),
        ({"machine": Machine(processor="Zen", cores=1)}, f"processor Zen / {processor()}"),
    ],
)
def test_what_a_document_states_of_its_machine_excuses_networks_alone(
    stated: dict[str, Any], of_networks: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fingerprinting, "other_platform", lambda: "")
    (run, *_) = logged_runs(read(honest(runs=RUNS))).values()
    if "versions" in stated:
        stated = {"versions": msgspec.structs.replace(run.document.versions, **stated["versions"])}
    run = replace(run, document=msgspec.structs.replace(run.document, **stated))
    assert run.other_machine("") == ""
    found = run.other_machine("onnxruntime 1.32.0")
    assert found == (of_networks and f"Made elsewhere (run / here): {of_networks}.")


def test_runs_of_the_first_arithmetic_are_tried_on_new_seeds_and_not_repeated(
    submission: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert verify(submission, "--write") == 0
    submissions.change_documents(submission, lambda _: {"arithmetic": 1})
    (group_,), (part,) = read(submission).groups.values(), read_review(submission).verifications
    old = msgspec.structs.replace(part, runs=group_.digests("sequential"))
    write_review(submission, Review(verifications=[old]))
    assert level_of(submission) == "verified"
    capsys.readouterr()
    assert verify(submission) == 0
    out = capsys.readouterr().out
    assert f"not repeated: {RUNS} runs of the first arithmetic" in out
    assert "new seeds: p = " in out


def test_no_verification_of_runs_of_the_first_arithmetic_is_stored(
    submission: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    submissions.change_documents(submission, lambda _: {"arithmetic": 1})
    assert verify(submission, "--write") == 1
    out = capsys.readouterr().out
    assert f"{RUNS} runs of the first arithmetic" in out
    assert "python -m tools.record_again" in out
    assert level_of(submission) == "claimed"


def test_an_independent_program_repeats_logged_episodes_to_the_last_bit() -> None:
    path = honest() / GROUP / "sequential" / "run0.csv"
    with np.load(path.with_suffix(".npz")) as file:
        arrays = dict(file)
    for row in read_log(path).iloc[::97].to_dict("records"):
        start = f"stage{row['stage']}/"
        policy = {name.removeprefix(start): arrays[name] for name in arrays if name.startswith(start)}
        env, rewards, is_over = make(row["task"]), list[float](), False
        seen, _ = env.reset(seed=row["seed"])
        space: Any = env.action_space
        while not is_over:
            action = np.clip(specified_action(policy, seen), space.low, space.high).astype(np.float32)
            seen, reward, terminated, truncated, _ = env.step(action)
            rewards.append(float(reward))
            is_over = terminated or truncated
        assert (math.fsum(rewards), len(rewards)) == (row["return"], row["length"])


def test_policies_that_were_mended_are_run_again(submission: Path) -> None:
    path = submission / GROUP / "sequential" / "run0.npz"
    whole = path.read_bytes()
    path.write_bytes(whole[:1000])
    assert verify(submission) == 1
    path.write_bytes(whole)
    assert verify(submission) == 0


def move_policies(submission: Path) -> Path:
    """Moves the policies of the first run to another address."""
    path = submission / GROUP / "sequential" / "run0.npz"
    elsewhere, stated = path.rename(submission.parent / "elsewhere.npz"), read_run(path.with_suffix(".json"))
    assert stated.policies is not None
    there = msgspec.structs.replace(stated.policies, url=elsewhere.as_uri(), size=0)
    submissions.change_document(path.with_suffix(".json"), policies=there)
    return elsewhere


def test_policies_that_lie_elsewhere_are_fetched_before_they_run_without_a_network(submission: Path) -> None:
    elsewhere = move_policies(submission)
    assert verify(submission, "--fetch") == 0
    elsewhere.unlink()
    assert verify(submission, "--write") == 0


def test_an_address_with_another_file_decides_nothing_and_is_fetched_again(
    submission: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    elsewhere = move_policies(submission)
    whole = elsewhere.read_bytes()
    elsewhere.write_bytes(b"an error page")
    assert verify(submission, "--write") == 2
    assert "another file than the run states" in capsys.readouterr().err
    assert not (submission / "review.toml").exists()
    elsewhere.write_bytes(whole)
    assert verify(submission, "--write") == 0


def test_a_submission_that_cannot_be_verified_now_does_not_stop_the_next(
    submission: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    first = copy(submission, submission.parent / "first")

    def away(submission: Submission, *arguments: Any, **keywords: Any) -> Report:
        if submission.path == first:
            raise BenchError("not-fetched", "The server does not answer.", "first")
        return verify_submission(submission, *arguments, **keywords)

    monkeypatch.setattr(verification_cli, "verify", away)
    options = ("--seeds", VALUE, "--cache", str(submission.parent / "cache"))
    assert main([str(first), str(submission), *options]) == 2
    output = capsys.readouterr()
    assert "The server does not answer." in output.err
    assert "mine: verified" in output.out


def test_a_cache_that_is_not_writable_is_named_before_anything_runs(
    submission: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(verification_cli, "verify", lambda *_, **__: pytest.fail("it was run"))
    cache = submission / "submission.toml" / "cache"  # below a file
    assert main([str(submission), "--cache", str(cache)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert str(cache) in line and "not writable" in line and "--cache DIR" in line


def test_a_verification_that_died_goes_on_and_keeps_every_finished_cell(
    submission: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run_cell, started = episodes.run_cell, list[episodes.Cell]()

    def dies(members: Any, policy: Any, cell: episodes.Cell) -> Any:
        started.append(cell)
        if len(started) == 5:
            raise KeyboardInterrupt
        return run_cell(members, policy, cell)

    monkeypatch.setattr(episodes, "run_cell", dies)
    assert verify(submission, "--write") == 130
    assert f"--seeds {VALUE}" in capsys.readouterr().err
    assert not (submission / "review.toml").exists(), "no half-written review"
    assert verify(submission, "--write") == 0
    tasks = len(group(GROUP).tasks)
    assert len(started) == 1 + 2 * RUNS * (tasks + 1) * tasks, "the prescribed and the new seeds of each cell"


@pytest.mark.usefixtures("in_this_process")
def test_the_same_seeds_give_the_same_record_whatever_else_was_drawn(tmp_path: Path) -> None:
    records = list[Verification]()
    for name in ("first", "again"):
        submission = copy(honest("gaussian", RUNS), tmp_path / name / "mine")
        change_log(submission, lambda row: {"return": row["return"] + 0.2})
        np.random.seed(len(records))  # noqa: NPY002 - a global generator must not matter
        assert verify(submission, "--write") == 0
        records += read_review(submission).verifications
    first, again = records
    assert msgspec.structs.replace(again, date=first.date) == first
    assert (first.passed, 0.004 < first.p_value < 1) == (True, True)
    assert (first.episodes, first.repeated) == (0, 0), "they sample, so none is tried to repeat"


def test_another_engine_repeats_nothing(
    submission: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(fingerprinting, "engine", lambda: {"mujoco": "3.9.0", "gymnasium": "1.3.0"})
    assert verify(submission, "--write") == 2
    assert "but mujoco 3.9.0" in capsys.readouterr().err
    assert not (submission / "review.toml").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows limits no processor time")
def test_policies_that_are_too_slow_are_undecided_until_somebody_gives_them_more_time(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    submission = copy(honest(runs=1), tmp_path / "mine")
    assert verify(submission, "--write", "--hours", "0") == 1
    said = "undecided: too slow, with 0 hours of processor time in all and 60 s a cell"
    assert said in capsys.readouterr().out
    found = read(submission)
    assert found.manifest is not None
    (part,), (submitted,) = found.review.verifications, found.groups.values()
    digests = submitted.digests("sequential")
    assert (part.passed, part.cells, part.runs) == (False, 0, digests)
    assert "undecided: too slow" in why_claimed(found.review, found.manifest.digest, digests)
    assert after_merge.runs_without_verdict(found) == {}, "a job does not try it again"
    assert verify(submission, "--write") == 0
    assert level_of(submission) == "verified"


@pytest.mark.usefixtures("in_this_process")
@pytest.mark.parametrize(("head", "why"), [("deterministic", "in the log"), ("gaussian", "nearly the same")])
def test_no_second_draw_is_played_for_runs_that_are_refuted_already(
    tmp_path: Path, head: str, why: str
) -> None:
    submission = copy(honest(head, RUNS), tmp_path / "mine")
    change_log(submission, lambda row: {"return": row["return"] + 50})
    if head == "gaussian":
        first = read_policies(submission, group(GROUP), "sequential", 0)
        submissions.change_policies(submission, lambda stored: stored.update(first))
    assert verify(submission, "--write") == 1
    (part,) = read_review(submission).verifications
    assert why in part.difference
    assert (part.p_value <= review.NEW_SEEDS_ALPHA, part.second_p_value) == (True, None)


@pytest.mark.usefixtures("in_this_process")
@pytest.mark.parametrize("is_undecided", [True, False])
def test_a_second_draw_is_undecided_if_it_needs_more_time_and_refused_if_the_policies_fail(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_undecided: bool
) -> None:
    submission = copy(honest("gaussian", RUNS), tmp_path / "mine")
    play, draws = episodes.Player.play, list[Any]()

    def slow(player: episodes.Player, requests: Any) -> Any:
        draws.extend(requests[:1] if any(each.cells for each in requests) else ())
        if len(draws) == 1 or not any(each.cells for each in requests):
            return play(player, requests)
        if is_undecided:
            raise BenchError(limits.TOO_SLOW, "The processor time was used up.")
        return [episodes.Played(problem="A step took too long.") for _ in requests]

    change_log(submission, lambda row: {"return": row["return"] + 50})
    monkeypatch.setattr(episodes.Player, "play", slow)
    assert verify(submission, "--write") == 1
    (part,) = read_review(submission).verifications
    assert (len(draws), part.passed, part.undecided is not None) == (2, False, is_undecided)
    assert part.second_p_value == (None if is_undecided else 0)


def test_a_policy_of_another_task_is_refused(submission: Path) -> None:
    members = group(GROUP)
    keys = policy_keys("sequential", members)
    wrong = dict.fromkeys(keys, submissions.network(1, actions=6))
    played = read_policies(submission, members, "sequential", 0)
    submissions.write_run_files(submission, "sequential", 0, wrong, played)
    assert verify(submission, "--write") == 1
    assert "6 actions" in read_review(submission).verifications[0].difference


@pytest.mark.parametrize("value", ["xyz", "3f", "3f" * 65])
def test_seeds_that_are_no_such_number_are_named(
    submission: Path, value: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(submission), "--seeds", value]) == 2
    assert "--seeds" in capsys.readouterr().err


def test_several_processes_find_the_same(verified: Path, tmp_path: Path) -> None:
    submission = copy(honest(runs=RUNS), tmp_path / "mine")
    assert verify(submission, "--write", "--jobs", "2") == 0
    (once,), (again,) = (read_review(each).verifications for each in (verified, submission))
    assert msgspec.structs.replace(again, date=once.date) == once


@pytest.mark.slow
def test_an_older_processor_prints_and_records_the_same_bytes(tmp_path: Path) -> None:
    """Each episode differs where numpy multiplies the float32 matrices that trained policies have."""
    submission = copy(honest(runs=1), tmp_path / "mine")
    rng, shapes = np.random.default_rng(0), ((21, 64), (64, 64), (64, 3))
    policies = {
        key: Policy(
            np.zeros(3, "f4"),
            np.ones(3, "f4"),
            weights=tuple(rng.normal(0, 0.3, shape).astype("f4") for shape in shapes),
            biases=tuple(np.zeros(width, "f4") for _, width in shapes),
            activation="tanh",
        )
        for key in policy_keys("sequential", group(GROUP))
    }
    submissions.write_run_files(submission, "sequential", 0, policies)
    features = np.show_config("dicts")["SIMD Extensions"]["found"]  # those that numpy chooses at run time
    older = {"OPENBLAS_CORETYPE": "Prescott", "NPY_DISABLE_CPU_FEATURES": " ".join(features)}
    found = []
    for folder, variables in ((tmp_path / "here", {}), (tmp_path / "older", older)):
        command = [sys.executable, "-m", "gym_extensions", "verify", str(submission), "--seeds", VALUE]
        command += ["--record", str(folder), "--cache", str(folder / "cache")]
        done = subprocess.run(
            command, env=os.environ | variables, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        found.append((done.stdout, (folder / "mine.toml").read_bytes()))
    assert found[0] == found[1]


def test_a_later_run_with_the_policy_of_an_earlier_one_is_refused(submission: Path, tmp_path: Path) -> None:
    first, noisy = read_policies(submission, group(GROUP), "sequential", 0), {}
    for key, policy in first.items():
        assert isinstance(policy, Policy)
        noisy[key] = replace(policy, biases=(policy.biases[0] + 0.1,))
    submissions.write_run_files(submission, "sequential", 2, noisy)
    last, player = f"{GROUP}/sequential/run2", episodes.Player(tmp_path / "store")
    report = verify_submission(read(submission), VALUE, player, Fetcher(tmp_path / "cache"), names=[last])
    assert f"{last}: nearly the same policy as {GROUP}/sequential/run0" in report.twins
    assert report.verification is not None
    assert (list(report.verification.runs), report.verification.passed) == ([last], False)


def test_a_copy_of_a_run_that_was_trained_here_is_refused(
    submission: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    forged, trained = copy(submission, submission.parent / "forged"), submission / "trained/1"
    runs = read(submission).groups[f"{GROUP}-v0"].digests("sequential")
    training = review.Training(date="2026-01-01", version="1", commit="3f" * 20, agent="0" * 64, runs=runs)
    trained.mkdir(parents=True)
    (submission / GROUP).rename(trained / GROUP)
    trained.with_suffix(".toml").write_text(review.training_text(training))
    assert verify(forged, "--write") == 1
    assert f"nearly the same policy as mine/trained/1/{GROUP}/sequential/run0" in capsys.readouterr().out


@pytest.mark.parametrize(("noise", "is_copy"), [(1e-2, True), (0.2, False)])
def test_a_noisy_copy_of_the_last_policy_of_a_verified_submission_is_refused(
    submission: Path, noise: float, is_copy: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    assert verify(submission, "--write") == 0
    forged, rng = copy(honest(runs=1), submission.parent / "forged"), np.random.default_rng(0)
    stored, last = read_policies(forged, group(GROUP), "sequential", 0), len(group(GROUP).tasks)
    for key, policy in stored.items():
        assert isinstance(policy, Policy)
        other = policy if key[0] == last else submissions.network(50 + key[0])
        weights = tuple(each * (1 + noise * rng.normal(size=each.shape)) for each in other.weights)
        stored[key] = replace(other, weights=weights)
    submissions.write_run_files(forged, "sequential", 0, stored)
    assert verify(forged, "--write") == int(is_copy)
    assert (f"nearly the same policy as mine/{GROUP}/sequential/run0" in capsys.readouterr().out) == is_copy
    assert verify(submission, "--write", "--seeds", VALUE) == 0, "the original stays as it is"
    assert level_of(submission) == "verified"

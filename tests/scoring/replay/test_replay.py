"""Replay tells a recorded episode from an invented one; every kind of lie has its row."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.baselines import train
from gym_extensions.envs import fingerprint
from gym_extensions.rollouts.problem import Problem
from gym_extensions.rollouts.reader import read
from gym_extensions.scoring.cli import main
from gym_extensions.scoring.replay.verify import verified, verify
from gym_extensions.scoring.scorecard.model import Scorecard

from .forgery import Arrays, forge, rewrite

GROUP = "pusher"  # its episodes are 100 steps long: 20 segments each


@pytest.fixture(scope="module")
def honest(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("submissions") / "honest"
    train("random", GROUP, "single", "smoke", 0, out=folder)
    return folder


@pytest.fixture
def copy(honest: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(honest, tmp_path / "copy"))


def traces(folder: Path) -> list[Path]:
    return sorted((folder / GROUP / "traces").iterdir())


def shift_action(arrays: Arrays) -> None:
    arrays["actions"][2] *= -1


def move_return_between_segments(arrays: Arrays) -> None:
    arrays["segment_returns"][3] += 0.5
    arrays["segment_returns"][4] -= 0.5


def start_a_segment_elsewhere(arrays: Arrays) -> None:
    arrays["state_qvel"][6, 0] += 5.0


def test_an_honest_sample_replays_and_says_how_much_it_is(honest: Path) -> None:
    verification = verify(honest)
    assert verification.problems == ()
    assert verification.level == "replayed (unsalted sample: 4 of 40 episodes)"


def test_a_changed_success_in_the_log_is_reported(copy: Path) -> None:
    log = copy / GROUP / "single.csv"
    assert log.read_text().count(",false,false,") == 40
    forge(copy, log, success="true")
    (problem,) = verify(copy).problems
    message = "Steps 95 and following: the episode ends without success, the log says with success."
    assert problem.message == message


@pytest.mark.parametrize(
    ("lie", "told"),
    [
        (shift_action, "Steps 0 and following: the rewards sum to "),
        (move_return_between_segments, "Steps 15 and following: the rewards sum to "),
        (
            start_a_segment_elsewhere,
            "Steps 30 and following: the state's 'qvel' before the next segment differs",
        ),
    ],
)
def test_a_lie_in_one_trace_is_found_at_its_first_segment(
    copy: Path, lie: Callable[[Arrays], object], told: str
) -> None:
    victim = forge(copy, copy / GROUP / "single.csv", lie)
    (problem,) = verify(copy).problems
    assert (problem.rule, problem.where) == ("replay-differs", victim)
    assert problem.message.startswith(told)
    assert verify(copy).level is None


@pytest.mark.parametrize(
    ("break_", "message"),
    [
        (lambda arrays: arrays.pop("segment_returns"), "The array 'segment_returns' is missing."),
        (
            lambda arrays: arrays.update(segment_steps=np.array(25)),
            "'segment_steps' is 25; it is 5 for Pusher.",
        ),
        (
            lambda arrays: arrays.update(actions=arrays["actions"][:-1]),
            "'actions' is float32 of shape (99, 7); expected float32 of shape (100, …).",
        ),
        (
            lambda arrays: arrays["state_qpos"].fill(np.nan),
            "'state_qpos' contains a value that is not finite.",
        ),
        (
            lambda arrays: arrays.update(segment_returns=np.zeros((20, 2))),
            "'segment_returns' is float64 of shape (20, 2); expected float64 of shape (20,).",
        ),
        (lambda arrays: arrays.update(luck=np.zeros(1)), "Unexpected array 'luck'."),
    ],
)
def test_a_trace_of_the_wrong_form_is_told(
    copy: Path, break_: Callable[[Arrays], object], message: str
) -> None:
    rewrite(traces(copy)[0], break_)
    (problem,) = verify(copy).problems
    assert (problem.rule, problem.message) == ("trace-malformed", message)


def add_a_state_of_luck(arrays: Arrays) -> None:
    arrays["state_luck"] = np.zeros((len(arrays["state_qpos"]), 2))


def leave_out_a_joint(arrays: Arrays) -> None:
    arrays["state_qpos"] = arrays["state_qpos"][:, 1:].copy()


def leave_out_an_action(arrays: Arrays) -> None:
    arrays["actions"] = arrays["actions"][:, 1:].copy()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda arrays: arrays.pop("state_qvel"),
            "Steps 0 and following: the recorded states do not fit the task: 'qvel'.",
        ),
        (
            add_a_state_of_luck,
            "Steps 0 and following: the recorded states do not fit the task: 'luck'.",
        ),
        (
            leave_out_a_joint,
            "Steps 0 and following: the recorded states do not fit the task: 'qpos'.",
        ),
        (
            leave_out_an_action,
            "Steps 0 and following: the recorded actions do not fit the task, whose actions are (7,).",
        ),
    ],
)
def test_what_does_not_fit_the_task_is_told_of_its_own_trace_alone(
    copy: Path, change: Callable[[Arrays], object], message: str
) -> None:
    victim = forge(copy, copy / GROUP / "single.csv", change)
    (problem,) = verify(copy).problems
    assert (problem.rule, problem.where, problem.message) == ("replay-differs", victim, message)


def test_a_trace_whose_data_is_damaged_is_told(copy: Path) -> None:
    victim = traces(copy)[0]
    rewrite(victim, lambda arrays: arrays.update(actions=np.zeros((1000, 7), np.float32)))
    data = bytearray(victim.read_bytes())
    data[data.index(b"PK\x01\x02") + 16] ^= 0xFF  # the checksum of the first array
    victim.write_bytes(bytes(data))
    assert read(copy).problems == ()
    (problem,) = verify(copy).problems
    assert (problem.rule, problem.message) == ("trace-malformed", "The file cannot be read.")


def test_unstable_states_leave_no_log_of_the_simulator(
    copy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    log = copy / GROUP / "single.csv"
    forge(copy, log, lambda arrays: arrays["state_qvel"].__setitem__((slice(0, 1), 0), 1e200))
    assert {problem.rule for problem in verify(copy).problems} == {"replay-differs"}
    assert list((tmp_path / "here").iterdir()) == []


@pytest.mark.parametrize("value", [100.0, 1.7e308])
def test_a_return_that_is_not_the_sum_of_its_segments_is_told(copy: Path, value: float) -> None:
    def brag(arrays: Arrays) -> None:
        arrays["segment_returns"][:2] = value

    rewrite(traces(copy)[0], brag)
    (problem,) = verify(copy).problems
    assert problem.rule == "trace-malformed"
    assert "The segment returns sum to" in problem.message


def test_a_trace_that_the_log_asks_for_and_is_not_there_is_told(copy: Path) -> None:
    victim = traces(copy)[2]
    victim.unlink()
    (problem,) = verify(copy).problems
    assert (problem.rule, problem.where) == ("trace-missing", f"{GROUP}/traces/{victim.name}")


def test_a_submission_without_traces_stays_validated_and_says_so(
    copy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.rmtree(copy / GROUP / "traces")
    assert main([str(copy), "--verify", "--json"]) == 0
    (card,) = json.loads(capsys.readouterr().out)["submissions"]
    assert (card["trust"], card["problems"]) == ("validated", [])
    assert card["notes"] == ["It holds no traces: nothing could be replayed."]
    assert card["groups"] != {}


def test_of_many_missing_traces_some_are_named_and_the_rest_counted(
    copy: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gym_extensions.rollouts.problem.PROBLEMS_LISTED", 1)
    for victim in traces(copy)[1:]:
        victim.unlink()
    assert main([str(copy), "--verify", "--json"]) == 1
    (card,) = json.loads(capsys.readouterr().out)["submissions"]
    assert [one["rule"] for one in card["problems"]] == ["trace-missing"] * 2
    assert (card["problems"][1]["where"], card["problems"][1]["message"]) == (
        "copy",
        "2 more problems of this rule in the submission.",
    )


def test_a_log_that_was_edited_asks_for_other_episodes(copy: Path) -> None:
    log = copy / GROUP / "single.csv"
    head, first, *rest = log.read_text().splitlines()
    cells = first.split(",")
    cells[6] = repr(float(cells[6]) + 1.0)
    log.write_text("\n".join([head, ",".join(cells), *rest]) + "\n")
    assert "trace-missing" in {problem.rule for problem in verify(copy).problems}


def test_score_verify_gives_the_level_of_trust_and_the_exit_status(
    honest: Path, copy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(honest), "--verify", "--json"]) == 0
    (card,) = json.loads(capsys.readouterr().out)["submissions"]
    assert card["trust"] == "replayed (unsalted sample: 4 of 40 episodes)"
    forge(copy, copy / GROUP / "single.csv", shift_action)
    assert main([str(copy), "--verify", "--json"]) == 1
    (card,) = json.loads(capsys.readouterr().out)["submissions"]
    assert (card["trust"], card["groups"]) == (None, {})
    assert card["problems"][0]["rule"] == "replay-differs"


def test_a_submission_with_problems_is_not_replayed(copy: Path) -> None:
    (copy / "submission.toml").write_text("format = 2\n")
    verification = verify(copy)
    assert verification.replayed == 0
    assert verification.problems != ()


def test_a_reported_scorecard_and_one_with_problems_are_returned_unchanged(copy: Path) -> None:
    reported = Scorecard(name="copy", title="", trust="reported", manifest=None)
    assert verified(reported, copy) is reported
    problem = Problem("manifest-missing", "submission.toml", "It is missing.", "Add it.")
    refused = Scorecard(name="copy", title="", trust=None, manifest=None, problems=(problem,))
    assert verified(refused, copy) is refused


def test_another_engine_replays_nothing(
    copy: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(fingerprint, "engine", lambda: {"mujoco": "3.17.0", "gymnasium": "1.4.0"})
    assert main(["--verify", str(copy)]) == 2
    printed = capsys.readouterr()
    assert printed.err.startswith("error: Episodes are recorded and replayed with the published engine, but ")
    assert "replayed (" not in printed.out

"""``gym-extensions watch`` replays audited episodes and writes where the body was."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.baselines import train
from gym_extensions.catalog.registry import task
from gym_extensions.envs import make
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.trace_reader import RecordedEpisode
from gym_extensions.scoring.poses.files import load
from gym_extensions.scoring.poses.model import Poses
from gym_extensions.scoring.replay.cli import main, watch
from gym_extensions.scoring.replay.motion import motions
from gym_extensions.scoring.replay.poses import frames_of, timing_of

GROUP = "pusher"
COMMITTED = Path(__file__).parents[3] / "scoring" / "poses"


@pytest.fixture(scope="module")
def entry(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("submissions") / "entry"
    train("random", GROUP, "sequential", "smoke", 0, out=folder, progress=False)
    return folder


@pytest.fixture(scope="module")
def poses(entry: Path, tmp_path_factory: pytest.TempPathFactory) -> Poses:
    [(path, is_new)] = watch(entry, tmp_path_factory.mktemp("poses"))
    document = load(path)
    assert is_new and document is not None
    return document


def test_every_task_is_shown_right_after_its_training_and_at_the_end(poses: Poses) -> None:
    cells = [(row.task, row.after.stage, row.end.stage if row.end else None) for row in poses.tasks]
    assert cells == [
        ("gym_extensions/Pusher-v0", 1, 2),
        ("gym_extensions/PusherMovingGoal-v0", 2, None),
    ]


def test_a_clip_has_the_returns_of_all_episodes_of_its_cell(entry: Path, poses: Poses) -> None:
    clip = poses.tasks[0].after
    rows = [line.split(",") for line in (entry / GROUP / "sequential.csv").read_text().splitlines()[1:]]
    returns = [round(float(row[6]), 2) for row in rows if row[1] == "1" and row[2] == poses.tasks[0].task]
    assert list(clip.returns) == returns
    assert len(returns) == 20


def test_the_frames_are_those_of_the_recorded_episode(entry: Path, poses: Poses) -> None:
    row = poses.tasks[1]
    name = f"sequential-run0-stage2-PusherMovingGoal-episode{row.after.episode}.npz"
    with np.load(entry / GROUP / "traces" / name) as trace:
        states = trace["state_qpos"]
    track = row.after.coordinates(row.unit)
    assert row.steps_per_second == pytest.approx(20.0)
    assert row.after.frames == 76  # 100 steps are 5 s, at 15 per second, and the start
    for index in range(0, len(states), 4):
        step = 5 * (index + 1) - 1
        frame = step / row.steps_per_frame
        if frame == int(frame):
            np.testing.assert_allclose(track[int(frame)], states[index], atol=0.0051)


def test_poses_that_are_up_to_date_are_kept(
    entry: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(entry), "--out", str(tmp_path)]) == 0
    path = tmp_path / "entry" / "pusher.json"
    before = path.read_bytes()
    assert main([str(entry), "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().out == f"{path}\n{path} (up to date)\n"
    assert main([str(entry), "--out", str(tmp_path), "--again"]) == 0
    assert path.read_bytes() == before


def test_the_shown_episode_is_not_the_one_with_the_largest_return(entry: Path, poses: Poses) -> None:
    rows = [line.split(",") for line in (entry / GROUP / "sequential.csv").read_text().splitlines()[1:]]
    for row in poses.tasks:
        for clip in filter(None, (row.after, row.end)):
            cell = [float(each[6]) for each in rows if (each[1], each[2]) == (str(clip.stage), row.task)]
            assert cell[clip.episode] < max(cell)


def test_a_changed_trace_writes_nothing(entry: Path, tmp_path: Path) -> None:
    broken = tmp_path / "entry"
    shutil.copytree(entry, broken, ignore=shutil.ignore_patterns(".progress"))
    for path in (broken / GROUP / "traces").iterdir():
        with np.load(path) as file:
            arrays = {name: file[name].copy() for name in file.files}
        arrays["state_qvel"][3, 0] += 1.0
        np.savez_compressed(path, **arrays)
    with pytest.raises(BenchError, match="The log commits to another trace"):
        watch(broken, tmp_path / "poses")
    assert not (tmp_path / "poses").exists()


def test_an_entry_without_traces_has_no_poses(
    entry: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bare = tmp_path / "bare"
    shutil.copytree(entry, bare, ignore=shutil.ignore_patterns(".progress", "traces"))
    assert main([str(bare), "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().err == f"{bare} has no traces of the sequential protocol.\n"


def test_a_submission_with_problems_is_refused(tmp_path: Path) -> None:
    (tmp_path / "entry").mkdir()
    with pytest.raises(BenchError):
        watch(tmp_path / "entry", tmp_path)


def test_a_path_on_a_map_is_the_position_after_every_step() -> None:
    row = task("State-Based-Navigation-2d-Map0-Goal0")
    env, steps = make(row.id), 23
    env.reset(seed=4)
    single = env.unwrapped
    actions = np.random.default_rng(0).uniform(-5, 5, (steps, 2)).astype(np.float32)
    positions, states = [single.save_state()["position"]], []  # type: ignore[attr-defined]
    for index, action in enumerate(actions):
        env.step(action)
        positions.append(single.save_state()["position"])  # type: ignore[attr-defined]
        if (index + 2) % 10 == 0 and index + 2 < steps:
            states.append(single.save_state())  # type: ignore[attr-defined]
    recorded = {name: np.stack([state[name] for state in states]) for name in states[0]}
    episode = RecordedEpisode("trace", row, 4, steps, False, False, actions, np.zeros(3), recorded)
    [track] = motions(row, [episode], 1000)
    np.testing.assert_array_equal(track, positions)
    states[0]["position"] += 1.0
    other = {name: np.stack([state[name] for state in states]) for name in states[0]}
    with pytest.raises(BenchError, match="Steps 0 to 10 differ from the recorded ones"):
        motions(row, [replace(episode, states=other)], 1000)
    timing = timing_of(row)
    assert timing.steps_per_frame == 4
    np.testing.assert_array_equal(frames_of(track, timing)[-1], positions[-1])


@pytest.mark.parametrize(
    "path", sorted(COMMITTED.glob("*/*.json")), ids=lambda path: "/".join(path.parts[-2:])
)
def test_committed_poses_belong_to_the_committed_logs(path: Path) -> None:
    document = load(path)
    assert document is not None
    log = COMMITTED.parents[1] / "submissions" / document.submission / path.stem / "sequential.csv"
    rows = [line.split(",")[:7] for line in log.read_text().splitlines()[1:]]
    returns = {(row[0], row[1], row[2], int(row[3])): float(row[6]) for row in rows}
    for row in document.tasks:
        for clip in filter(None, (row.after, row.end)):
            cell = [returns[str(document.run), str(clip.stage), row.task, index] for index in range(20)]
            assert clip.returns == pytest.approx(cell, abs=0.0051), "run `gym-extensions watch`"

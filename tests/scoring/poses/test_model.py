"""Poses are shown beside the results that they belong to, and beside no others."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gym_extensions.errors import BenchError
from gym_extensions.scoring.poses.files import load, load_entry, write
from gym_extensions.scoring.poses.model import Clip, Poses, TaskPoses, motion_of


def clip(stage: int, mean: float) -> Clip:
    track = np.array([[0.0, 1.25], [0.51, 1.2], [1.0, -0.3]])
    return Clip(
        stage=stage,
        episode=3,
        steps=30,
        success=None,
        returns=(mean - 1, mean, mean + 1),
        frames=3,
        motion=motion_of(track, 0.01),
    )


def poses(run: int = 0) -> Poses:
    timing = {"unit": 0.01, "steps_per_second": 20.0, "steps_per_frame": 4 / 3}
    first = TaskPoses(task="gym_extensions/Hopper-v0", after=clip(1, 50.0), end=clip(2, 20.0), **timing)
    last = TaskPoses(task="gym_extensions/HopperGravityHalf-v0", after=clip(2, 70.0), end=None, **timing)
    return Poses(submission="entry", group="hopper-pair-v0", run=run, tasks=(first, last))


MATRIX = (((1.0, 2.0), (50.0, 3.0), (20.0, 70.0)),)
"""Mean returns [run][stage][task] of one run."""


def test_coordinates_survive_at_the_resolution() -> None:
    np.testing.assert_allclose(clip(1, 0.0).coordinates(0.01), [[0.0, 1.25], [0.51, 1.2], [1.0, -0.3]])


def test_poses_belong_to_results_with_the_same_mean_returns() -> None:
    assert poses().shows((0,), MATRIX)


@pytest.mark.parametrize(
    ("runs", "matrix"),
    [
        ((1,), MATRIX),
        ((0,), (((1.0, 2.0), (50.0, 3.0), (20.1, 70.0)),)),
        ((0,), (((1.0, 2.0), (50.0, 3.0)),)),
    ],
    ids=["another run", "another return", "another number of tasks"],
)
def test_poses_of_other_results_are_not_shown(
    runs: tuple[int, ...], matrix: tuple[tuple[tuple[float, ...], ...], ...]
) -> None:
    assert not poses().shows(runs, matrix)


def test_a_motion_of_incomplete_frames_is_refused() -> None:
    broken = Clip(stage=1, episode=0, steps=1, success=None, returns=(1.0,), frames=2, motion="ACA")
    with pytest.raises(BenchError, match="3 numbers do not make 2 frames"):
        broken.coordinates(0.01)


def test_files_of_an_entry_are_read_by_group(tmp_path: Path) -> None:
    write(tmp_path, "hopper-pair", poses())
    assert load_entry(tmp_path, "entry") == {"hopper-pair-v0": poses()}
    assert load_entry(tmp_path, "nobody") == {}
    assert load_entry(None, "entry") == {}


def test_a_damaged_file_names_itself_and_the_command(tmp_path: Path) -> None:
    path = write(tmp_path, "hopper-pair", poses())
    path.write_text('{"format": 2}')
    with pytest.raises(BenchError) as error:
        load(path)
    assert error.value.message.startswith("It cannot be read: ")
    assert error.value.where == str(path)
    assert error.value.hint == "Write it again with `gym-extensions watch`."

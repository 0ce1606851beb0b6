"""Recorded actions are those of the submitted policy."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.baselines import train
from gym_extensions.rollouts.policies import Policy
from gym_extensions.scoring.replay.verify import verify


@pytest.fixture(scope="module")
def with_policies(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("submissions") / "trpo"
    train("trpo", "hopper-motor-noise", "single", "smoke", 0, out=folder)
    return folder


def test_recorded_actions_are_those_of_the_policy(with_policies: Path, tmp_path: Path) -> None:
    assert verify(with_policies).problems == ()
    shutil.copytree(with_policies, tmp_path / "copy", ignore=shutil.ignore_patterns(".progress"))
    policies = tmp_path / "copy/hopper-motor-noise/policies"
    shutil.copy(
        policies / "single-run0-stage1-Hopper.npz", policies / "single-run0-stage1-HopperMotorNoise.npz"
    )
    problem, *others = verify(tmp_path / "copy").problems
    assert {problem.rule, *(other.rule for other in others)} == {"actions-differ"}
    assert problem.where.startswith("hopper-motor-noise/traces/single-run0-stage1-HopperMotorNoise-episode")
    assert problem.message.startswith(
        "Steps 0 and following: the recorded action differs from the policy's by "
    )
    assert problem.hint == (
        "Store the policy of the stage that its name states; "
        "if it was, tell the maintainers the platform that it was made on."
    )


def test_a_policy_of_other_observations_or_actions_is_reported(with_policies: Path, tmp_path: Path) -> None:
    shutil.copytree(with_policies, tmp_path / "copy", ignore=shutil.ignore_patterns(".progress"))
    wrong = Policy(np.zeros(2), np.ones(2), (np.zeros((9, 2)),), (np.zeros(2),))
    for path in (tmp_path / "copy/hopper-motor-noise/policies").iterdir():
        path.write_bytes(wrong.to_bytes())
    assert {problem.message for problem in verify(tmp_path / "copy").problems} == {
        "Steps 0 and following: The actions have 3 values; the policy has 2."
    }

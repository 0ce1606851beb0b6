"""Candidates for experts: stored policies, fitting to tasks with range beams, what a task is for."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.catalog.tasks import task
from gym_extensions.references import experts
from gym_extensions.submissions.policies.mlp import Policy
from gym_extensions.submissions.poses import PolicyPoses
from tools.experts import candidates, published
from tools.experts.candidates import fitted
from tools.experts.recipes import meant

SUBMISSIONS = Path(__file__).resolve().parents[3] / "submissions"


def make_policy(inputs: int) -> Policy:
    rng = np.random.default_rng(0)
    return Policy(
        action_offset=np.zeros(3, np.float32),
        action_scale=np.ones(3, np.float32),
        weights=(rng.normal(size=(inputs, 4)).astype(np.float32), np.ones((4, 3), np.float32)),
        biases=(np.ones(4, np.float32), np.zeros(3, np.float32)),
        activation="tanh",
        observation_mean=rng.normal(size=inputs),
        observation_scale=np.full(inputs, 2.0),
        observation_clip=10.0,
    )


def test_new_beams_do_not_change_the_actions() -> None:
    rng = np.random.default_rng(1)
    policy, seen = make_policy(11), rng.normal(size=(5, 11))
    with_beams = np.concatenate([seen, rng.uniform(size=(5, 10))], axis=1)
    np.testing.assert_allclose(fitted(policy, 21).act(with_beams), policy.act(seen), rtol=1e-6)


def test_missing_beams_read_zero() -> None:
    policy, seen = make_policy(21), np.random.default_rng(1).normal(size=(5, 11))
    with_beams = np.concatenate([seen, np.zeros((5, 10))], axis=1)
    np.testing.assert_allclose(fitted(policy, 11).act(seen), policy.act(with_beams), rtol=1e-5)


def test_an_expert_is_provisional_if_too_few_episodes_show_what_the_task_is_for() -> None:
    assert meant(task("HumanoidStandup"), np.full(10, 150_000.0))
    assert not meant(task("HumanoidStandup"), np.full(10, 350_000.0))
    assert not meant(task("HopperWall"), np.array([3500.0, 100.0, 100.0]))
    assert not meant(task("Hopper"), np.zeros(10))


@pytest.mark.parametrize(
    ("protocol", "tasks"), [("sequential", 1), ("single", 1), ("joint", 5), ("cumulative", 5)]
)
def test_a_stored_policy_has_the_steps_of_its_run(protocol: str, tasks: int, tmp_path: Path) -> None:
    name = f"stored:trpo/hopper-gravity/{protocol}-run0-stage1"
    (step,) = candidates.history(candidates.Workplace(tmp_path, tmp_path), name)
    assert step.steps == tasks * 300_000


@pytest.mark.committed
def test_the_best_stored_policies_of_the_logs_have_files(tmp_path: Path) -> None:
    shutil.copytree(SUBMISSIONS / "sac/hopper-gravity", tmp_path / "sac/hopper-gravity")
    ranked = candidates.stored_candidates(tmp_path)
    means = [mean for mean, _ in ranked["HopperGravityHalf"]]
    assert means == sorted(means, reverse=True)
    assert all(name.startswith(candidates.STORED) for _, name in ranked["HopperGravityHalf"])


def test_poses_are_written_for_an_expert_that_has_none_of_its_policy(tmp_path: Path) -> None:
    for suffix in ("json", "npz"):
        shutil.copy(experts.DATA / f"Pusher.{suffix}", tmp_path)
    (line,) = published.write_poses(["Pusher"], tmp_path)
    path = Path(line)
    poses = PolicyPoses.load(path, "bad-poses", "")
    assert poses is not None
    assert poses.policy == experts.digest(experts.load("Pusher"))
    assert path.read_bytes() == (experts.DATA / "poses/Pusher.json").read_bytes()
    assert list(published.write_poses(["Pusher"], tmp_path)) == [f"{line}: up to date"]
    path.write_text(path.read_text().replace(poses.policy, "0" * len(poses.policy)))
    assert list(published.write_poses(["Pusher"], tmp_path)) == [line]

"""The poses of experts, which the pages of tasks show."""

from __future__ import annotations

import shutil
from pathlib import Path

from gym_extensions.references import experts
from gym_extensions.submissions.poses import PolicyPoses
from gym_extensions.verification.pose_recorder import write_expert_poses


def test_poses_are_written_for_an_expert_that_has_none_of_its_policy(tmp_path: Path) -> None:
    for suffix in ("json", "npz"):
        shutil.copy(experts.DATA / f"Pusher.{suffix}", tmp_path)
    (line,) = write_expert_poses(["Pusher"], tmp_path)
    path = Path(line)
    poses = PolicyPoses.load(path, "bad-poses", "")
    assert poses is not None
    assert poses.policy == experts.digest(experts.load("Pusher"))
    assert path.read_bytes() == (experts.DATA / "poses/Pusher.json").read_bytes()
    assert list(write_expert_poses(["Pusher"], tmp_path)) == [f"{line}: up to date"]
    path.write_text(path.read_text().replace(poses.policy, "0" * len(poses.policy)))
    assert list(write_expert_poses(["Pusher"], tmp_path)) == [line]

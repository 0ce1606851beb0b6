"""Snapshots of a submission: its episodes and policies by stage, put together."""

import shutil
from pathlib import Path

from gym_extensions.baselines import train
from gym_extensions.catalog.protocol import EVALUATION_EPISODES
from tools.snapshots import assembled_log, main

from ..conftest import trained_here


def test_a_learned_task_has_the_episodes_of_its_own_stage_and_others_those_of_the_present_one() -> None:
    header = "stage,task,rest"
    rows = [
        f"{stage},{task},{stage}{task}{episode}"
        for stage in range(3)
        for task in "ab"
        for episode in range(EVALUATION_EPISODES)
    ]
    found = assembled_log("\n".join([header, *rows, ""]), 2).splitlines()
    firsts = [line for line in found[1:] if line.endswith(("a0", "b0"))]
    assert firsts == ["0,a,0a0", "0,b,0b0", "1,a,1a0", "1,b,1b0", "2,a,1a0", "2,b,2b0"]
    assert (found[0], len(found)) == (header, 1 + len(rows))


def test_runs_that_were_trained_here_are_read_where_their_author_has_none(tmp_path: Path) -> None:
    source = tmp_path / "source"
    train("zero", "pusher", "sequential", "smoke", 0, out=source, progress=False)

    def assembled(out: Path) -> dict[str, bytes]:
        main([str(source), "--groups", "pusher", "--runs", "0", "--out", str(out)])
        return {path.name: path.read_bytes() for path in out.glob("pusher/sequential/*")}

    own = assembled(tmp_path / "own")
    assert "the submission source" in (tmp_path / "own/README.md").read_text("utf-8")
    trained_here(source)
    shutil.rmtree(source / "pusher")
    assert assembled(tmp_path / "trained") == own
    assert sorted(own) == ["run0.csv", "run0.json", "run0.npz"]

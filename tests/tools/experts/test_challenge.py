"""A policy that challenges an expert is evaluated on new seeds."""

from pathlib import Path

import numpy as np
from msgspec.structs import replace

from gym_extensions.catalog.tasks import task
from gym_extensions.references import experts, load_references
from tools.experts import candidates
from tools.experts.candidates import Workplace


def test_a_challenge_evaluates_cells_above_the_expert_on_seeds_of_its_own(tmp_path: Path) -> None:
    row = task("Pusher")
    before = load_references().tasks[row.id]
    assert before.expert is not None
    expert = replace(before.expert, mean=-45.0, standard_error=0.5)
    references = {**load_references().tasks, row.id: replace(before, expert=expert)}
    work = Workplace(tmp_path / "work")
    candidates.write_policy(tmp_path / "work/policies/run/1.npz", experts.load("Pusher"))
    cells = {"Pusher": [(-40.0, "run@1"), (-46.0, "run@2")], "HopperWall": [(9e9, "run@3")]}
    (line,) = candidates.challenge(work, cells, 5, references)  # HopperWall is provisional
    seeds = [experts.seed(row, "challenge", index) for index in range(5)]
    expected = np.mean(candidates.episodes(experts.load("Pusher"), row, seeds)[0])
    assert line.startswith("Pusher run@1: 1.532 in its log; in 5 episodes")  # (−40 + 54.41) / (−45 + 54.41)
    assert f"{expected:.1f} ±" in line
    assert line.endswith("beats the expert")
    expert.mean = -10.0
    assert list(candidates.challenge(work, cells, 5, references)) == []

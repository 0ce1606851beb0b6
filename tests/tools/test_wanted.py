"""Which runs complete the next look of the core board, and how many comparisons they would decide."""

from pathlib import Path

import pytest
from scipy import stats

from gym_extensions.catalog.groups import CORE, CORES
from gym_extensions.scoring.ranking.boards import CorePair
from gym_extensions.scoring.ranking.wanted import power_at_next_look
from tools.wanted import main

from ..conftest import MANIFEST, write_submission

GROUPS = tuple(name.removesuffix("-v0") for name in CORES[CORE])
PAIR = CorePair(*("a", "b", 10, False, 0.1, -0.1, 0.3, 0.2), verdict="open", exploratory=True, next_look=20)


def test_the_power_at_the_next_look_is_that_of_a_z_test() -> None:
    error = 0.2 / stats.norm.isf(0.01 / 6 / 2)
    expected = stats.norm.sf(stats.norm.isf(0.01 / 6 / 2) - 0.1 / error * 2**0.5)
    assert power_at_next_look(PAIR, 6) == pytest.approx(expected, rel=1e-12)


def test_groups_that_lack_the_same_runs_share_a_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    manifest = MANIFEST.replace('"smoke"', '"300k"')
    own, foreign = manifest.replace('"formula"', '"trpo"'), manifest
    options = {"groups": GROUPS[1:2], "protocols": ("sequential",)}
    for name, text in (("own", own), ("foreign", foreign)):
        write_submission(tmp_path, name=name, runs=(0, 1, 3), manifest=text, **options)  # type: ignore[arg-type]
    assert main([str(tmp_path)]) == 0
    first, *commands = capsys.readouterr().out.splitlines()
    assert first == "own: 33 runs complete its look at 5 runs."
    others = ",".join(name for name in GROUPS if name != GROUPS[1])
    assert f"train trpo --groups {others} --budget 300k --runs 0-4 " in commands[0]
    assert f"train trpo --groups {GROUPS[1]} --budget 300k --runs 2-4 " in commands[1]
    assert len(commands) == 2

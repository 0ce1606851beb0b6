"""Policies on new seeds: honest entries agree with their logs, inflated logs and other policies do not."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.baselines import train
from gym_extensions.baselines.submission.root import traces_root
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.auditing.submission_digest import submission_digest
from gym_extensions.rollouts.policies import Policy
from gym_extensions.scoring.cli import main
from gym_extensions.scoring.reevaluation.reevaluate import reevaluate
from gym_extensions.scoring.reevaluation.seeds import new_seed, new_seeds

GROUP = "hopper-motor-noise"
SALT, OTHER = "5a" * 32, "b7" * 32


@pytest.fixture(scope="module")
def honest(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("submissions") / "honest"
    train("random", GROUP, "single", "smoke", [0, 1], out=folder)
    return folder


@pytest.fixture
def copy(honest: Path, tmp_path: Path) -> Path:
    ignore = shutil.ignore_patterns(".progress")
    return Path(shutil.copytree(honest, tmp_path / "copy", ignore=ignore))


def change_returns(folder: Path, change: Callable[[float], float]) -> None:
    log = folder / GROUP / "single.csv"
    rows = [line.split(",") for line in log.read_text().splitlines()]
    for cells in rows[1:]:
        cells[6] = repr(change(float(cells[6])))
    log.write_text("".join(",".join(cells) + "\n" for cells in rows), newline="\n")


def put_policies(folder: Path, policy: Policy) -> None:
    for path in (folder / GROUP / "policies").iterdir():
        path.write_bytes(policy.to_bytes())


def test_a_new_seed_by_hand() -> None:
    digest = hashlib.sha256(f"d/{SALT}/a/3".encode()).digest()
    assert new_seed("d", SALT, "a", 3) == int.from_bytes(digest[:4], "little") % 2**31


def test_new_seeds_depend_on_the_submission_the_salt_and_the_task() -> None:
    keys = [("d", SALT, "g", "a"), ("e", SALT, "g", "a"), ("d", OTHER, "g", "a"), ("d", SALT, "g", "b")]
    seeds = [new_seeds(*key) for key in keys]
    assert len({seed for each in seeds for seed in each}) == 80


def test_an_honest_entry_agrees_with_its_log(honest: Path) -> None:
    result = reevaluate(honest, SALT)
    assert (result.problems, result.is_complete, result.cells) == ((), True, 4)
    assert result.p_value is not None and result.p_value > 0.05
    assert (result.digest, result.salt) == (submission_digest(honest), SALT)
    score = result.scores[f"{GROUP}-v0"]["single"]
    assert [(cell.run, cell.stage) for cell in score.cells] == [(0, 1), (0, 1), (1, 1), (1, 1)]
    assert score.fresh == pytest.approx(score.logged, rel=0.3)
    assert all(cell.fresh != cell.logged for cell in score.cells)
    assert reevaluate(honest, SALT) == result
    assert reevaluate(honest, OTHER).scores != result.scores


def test_inflated_returns_are_refused(copy: Path) -> None:
    change_returns(copy, lambda value: 2 * value)
    (problem,) = reevaluate(copy, SALT).problems
    assert (problem.rule, problem.where) == ("reevaluation-differs", "copy")
    assert problem.message.startswith(
        "The logged returns are higher than those of the policies on new seeds: mean "
    )


def test_worse_policies_than_those_of_the_log_are_refused(copy: Path) -> None:
    falls = Policy(np.zeros(3), np.ones(3), (np.zeros((11, 3)),), (np.array([1.0, -1.0, 1.0]),))
    put_policies(copy, falls)
    assert [problem.rule for problem in reevaluate(copy, SALT).problems] == ["reevaluation-differs"]


@pytest.mark.parametrize(
    ("policy", "message"),
    [
        (
            Policy(np.zeros(3), np.ones(3), (np.zeros((9, 3)),), (np.zeros(3),)),
            "The observations have 11 values; the policy has 9 inputs.",
        ),
        (
            Policy(np.zeros(2), np.ones(2), (np.zeros((11, 2)),), (np.zeros(2),)),
            "The policy has 2 actions; the task has 3.",
        ),
        (
            Policy(np.zeros(3), np.full(3, 1e308), (np.full((11, 3), 1e308),), (np.zeros(3),)),
            "The policy gives an action that is not finite.",
        ),
    ],
)
def test_a_policy_that_cannot_act_is_a_problem(copy: Path, policy: Policy, message: str) -> None:
    put_policies(copy, policy)
    problems = reevaluate(copy, SALT).problems
    assert {(problem.rule, problem.message) for problem in problems} == {("policy-fails", message)}


@pytest.mark.parametrize("salt", ["", "5A" * 32, "5a" * 31])
def test_a_salt_of_the_wrong_form_is_refused(copy: Path, salt: str) -> None:
    with pytest.raises(BenchError) as error:
        reevaluate(copy, salt)
    assert error.value.code == "bad-salt"


def test_a_submission_with_problems_is_not_evaluated(copy: Path) -> None:
    (copy / "submission.toml").write_text("format = 2\n")
    assert reevaluate(copy, SALT).problems != ()


def scorecard(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, dict[str, object]]:
    status = main([*arguments, "--json"])
    (card,) = json.loads(capsys.readouterr().out)["submissions"]
    return status, card


def test_score_reevaluate_gives_the_level_and_the_new_returns(
    honest: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    status, card = scorecard(capsys, str(honest), "--reevaluate", "--salt", SALT)
    assert status == 0
    assert card["trust"] == (
        "re-evaluated (4 cells of 20 episodes on new seeds; unsalted sample: 8 of 80 episodes)"
    )
    assert card["new_seeds"]["salt"] == SALT  # type: ignore[index]
    score = card["groups"][f"{GROUP}-v0"]["single"]["reevaluation"]  # type: ignore[index]
    assert len(score["cells"]) == 4


def test_a_submission_without_policies_keeps_its_level_and_says_so(
    copy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.rmtree(copy / GROUP / "policies")
    status, card = scorecard(capsys, str(copy), "--reevaluate", "--salt", SALT)
    assert (status, card["trust"]) == (0, "replayed (unsalted sample: 8 of 80 episodes)")
    assert card["notes"] == ["It holds no policies: nothing could be re-evaluated."]


def test_an_inflated_log_without_traces_is_refused(copy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    change_returns(copy, lambda value: 2 * value)
    shutil.rmtree(copy / GROUP / "traces")
    assert traces_root(copy) in (copy / "submission.toml").read_text()
    status, card = scorecard(capsys, str(copy), "--reevaluate", "--salt", SALT)
    assert (status, card["trust"], card["groups"]) == (1, None, {})


@pytest.mark.parametrize(
    "arguments", [["--reevaluate"], ["--salt", SALT], ["--reevaluate", "--salt", SALT, "--compare", "a", "b"]]
)
def test_options_that_do_not_belong_together_are_refused(copy: Path, arguments: list[str]) -> None:
    with pytest.raises(SystemExit) as exit_:
        main([*([str(copy)] if "--compare" not in arguments else []), *arguments])
    assert exit_.value.code == 2

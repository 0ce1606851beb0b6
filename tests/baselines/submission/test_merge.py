"""Merging submissions gives the files of training all runs in one; what does not fit is refused."""

from __future__ import annotations

import shutil
import tomllib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.baselines import Card, merge, train
from gym_extensions.baselines.submission.cli import main
from gym_extensions.baselines.tracing.trace import trace
from gym_extensions.catalog.custom_groups import with_custom
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.policies import Policy
from gym_extensions.scoring.replay.verify import verify

from ..conftest import QUICK_GROUP, digests

GROUP = QUICK_GROUP.name
GROUPS = with_custom([QUICK_GROUP])


class Guesses:
    """Acts with a constant that depends on the rewards of its random actions in training."""

    def __init__(self, observation_space: Any, action_space: Any, seed: int) -> None:
        self.space, self.generator = action_space, np.random.default_rng(seed)
        self.action = np.zeros(action_space.shape)

    def act(self, observations: Any) -> Any:
        return np.tile(self.action, (len(observations), 1))

    def learn(self, env: Any, steps: int) -> None:
        env.reset()
        for _ in range(steps // env.num_envs):
            actions = self.generator.uniform(-1, 1, (env.num_envs, *self.action.shape))
            self.action = np.full(self.action.shape, np.sin(env.step(actions)[1].sum()))

    def policy(self) -> Policy:
        return Policy(self.action, np.ones(self.action.shape))

    def card(self) -> Card:
        settings = {"max_kl": 0.01}
        return Card("guesses", evaluation="deterministic", hyperparameters=settings, stored_steps=250)


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Runs of one agent by folder: ``first`` has run 1, ``second`` run 0, ``both`` has both."""
    root = tmp_path_factory.mktemp("trained")
    for name, runs in {"first": [1], "second": [0], "both": [0, 1]}.items():
        options: Any = {"num_envs": 10, "evaluate_every": 500, "evaluate_episodes": 2}
        train(Guesses, QUICK_GROUP, "single", "smoke", runs, out=root / name, **options)
    return {name: root / name for name in ("first", "second", "both")}


@pytest.fixture
def pair(trained: dict[str, Path], tmp_path: Path) -> list[Path]:
    """Copies of the two submissions, as git contains them: without ``.progress``."""
    ignore = shutil.ignore_patterns(".progress")
    return [
        Path(shutil.copytree(trained[name], tmp_path / name, ignore=ignore)) for name in ("first", "second")
    ]


def joined(submissions: Iterable[Path], out: Path) -> Path:
    return merge(submissions, out, groups=[QUICK_GROUP])


def replace_in(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8", newline="\n")


def refusal(pair: list[Path]) -> str:
    out = pair[0].parent / "merged"
    before = [digests(path) for path in pair]
    with pytest.raises(BenchError) as error:
        joined(pair, out)
    assert sorted(path.name for path in out.parent.iterdir()) == ["first", "second"]
    assert [digests(path) for path in pair] == before
    return str(error.value)


def test_the_files_are_those_of_training_all_runs_in_one_submission(
    trained: dict[str, Path], pair: list[Path], quick_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = pair[0].parent / "merged"
    assert main([*map(str, pair), "--out", str(out), "--groups", str(quick_file)]) == 0
    assert capsys.readouterr().out == f"The submission is in {out}.\n"
    assert digests(out) == digests(trained["both"])
    assert (out / GROUP / "evaluations.csv").exists()
    verification = verify(out, GROUPS)
    assert (verification.problems, verification.replayed) == ((), 8)


def test_a_run_that_both_contain_is_merged_once(
    trained: dict[str, Path], pair: list[Path], tmp_path: Path
) -> None:
    joined([trained["both"], *pair], tmp_path / "merged")
    assert digests(tmp_path / "merged") == digests(trained["both"])


def test_different_policies_of_one_run_are_refused(trained: dict[str, Path], pair: list[Path]) -> None:
    shutil.rmtree(pair[0])
    shutil.copytree(trained["both"], pair[0], ignore=shutil.ignore_patterns(".progress"))
    policies = pair[1] / GROUP / "policies"
    first, second = (task.name for task in QUICK_GROUP.tasks)
    shutil.copy(policies / f"single-run0-stage1-{second}.npz", policies / f"single-run0-stage1-{first}.npz")
    assert f"Another submission has a different policy single-run0-stage1-{first}.npz." in refusal(pair)


def test_policies_are_left_out_if_a_submission_has_none(pair: list[Path], tmp_path: Path) -> None:
    shutil.rmtree(pair[0] / GROUP / "policies")
    assert not (joined(pair, tmp_path / "merged") / GROUP / "policies").exists()


def test_submissions_without_traces_are_merged_without(pair: list[Path], tmp_path: Path) -> None:
    for path in pair:
        shutil.rmtree(path / GROUP / "traces")
    assert not (joined(pair, tmp_path / "merged") / GROUP / "traces").exists()


def test_a_run_without_traces_stays_without(pair: list[Path], tmp_path: Path) -> None:
    shutil.rmtree(pair[1] / GROUP / "traces")
    merged = joined(pair, tmp_path / "merged") / GROUP / "traces"
    assert {path.name for path in merged.iterdir()} == {
        path.name for path in (pair[0] / GROUP / "traces").iterdir()
    }


def test_runs_without_traces_join_runs_whose_traces_a_salt_drew(
    trained: dict[str, Path], pair: list[Path], tmp_path: Path
) -> None:
    shutil.copytree(trained["second"] / ".progress", pair[1] / ".progress")
    salt = "5a17" * 16
    trace(pair[1], salt, groups=[QUICK_GROUP])
    assert f"{GROUP}/traces: The salts of the traces differ" in refusal(pair)
    trace(pair[0], groups=[QUICK_GROUP], runs=())
    merged = joined(pair, tmp_path / "merged")
    assert (merged / GROUP / "traces" / "salt.txt").read_text() == f"{salt}\n"
    trace(merged, salt, groups=[QUICK_GROUP], runs=[0])
    assert digests(merged / GROUP / "traces") == digests(pair[1] / GROUP / "traces")


def test_the_merged_manifest_has_the_largest_memory_and_all_versions(
    pair: list[Path], tmp_path: Path
) -> None:
    replace_in(pair[1] / "submission.toml", "stored_steps = 250", "stored_steps = 300")
    replace_in(pair[1] / "submission.toml", 'platform = "', 'platform = "Darwin-arm64 or ')
    (pair[1] / "submission.toml").write_text(
        (pair[1] / "submission.toml").read_text() + f'\n[archive]\nurl = ""\nsha256 = "{"0" * 64}"\n'
    )
    text = (joined(pair, tmp_path / "merged") / "submission.toml").read_text(encoding="utf-8")
    assert "stored_steps = 300" in text
    assert ", Darwin-arm64 or " in text
    assert "archive" not in text


def test_the_merged_manifest_has_the_packages_of_all(pair: list[Path], tmp_path: Path) -> None:
    packages = ('torch = "2.12.0"', 'torch = "2.13.0"\njax = "0.10.2"')
    for path, lines in zip(pair, packages, strict=True):
        replace_in(path / "submission.toml", "[versions]", f"[packages]\n{lines}\n\n[versions]")
    tables = tomllib.loads(
        (joined(pair, tmp_path / "merged") / "submission.toml").read_text(encoding="utf-8")
    )
    assert tables["packages"] == {"torch": "2.12.0, 2.13.0", "jax": "0.10.2"}


CHANGES: dict[str, tuple[str, str, str]] = {
    "agent": (
        'algorithm = "guesses"',
        'algorithm = "ppo"',
        "protocol.algorithm is 'guesses' in {} and 'ppo' here.",
    ),
    "budget": ('budget = "smoke"', 'budget = "100k"', "protocol.budget is 'smoke' in {} and '100k' here."),
    "claimed steps": ('"recorded"', '"claimed"', "protocol.steps is 'recorded' in {} and 'claimed' here."),
    "setting": ("max_kl = 0.0", "max_kl = 0.1", "hyperparameters.max_kl is "),
    "observes": (
        "boundaries = false",
        "boundaries = true",
        "observes.boundaries is False in {} and True here.",
    ),
    "code": ('commit = ""', 'commit = "abc"', "code.commit is '' in {} and 'abc' here."),
}


@pytest.mark.parametrize("name", CHANGES)
def test_another_agent_budget_or_setting_is_refused(name: str, pair: list[Path]) -> None:
    old, new, message = CHANGES[name]
    replace_in(pair[1] / "submission.toml", old, new)
    text = refusal(pair)
    assert text.startswith(f"{pair[1] / 'submission.toml'}: {message.format(pair[0])}")
    assert text.endswith("Merge only runs of one agent with one budget and one set of hyperparameters.")


def test_another_version_of_the_physics_is_refused(pair: list[Path]) -> None:
    replace_in(pair[1] / "submission.toml", 'mujoco = "4.0.0"', 'mujoco = "3.9.0"')
    assert refusal(pair) == (
        f"{pair[1]}: The submission breaks the rule foreign-version: submission.toml, [versions] mujoco: The "
        "version is '3.9.0'; the published tasks have '4.0.0'. Record the episodes with mujoco 4.0.0."
    )


def test_different_runs_with_one_number_are_refused(pair: list[Path]) -> None:
    for file in ("single.csv", "curves.csv", "evaluations.csv"):
        path = pair[1] / GROUP / file
        path.write_text(path.read_text().replace("\n0,", "\n1,").replace("single,0,", "single,1,"))
    for folder in ("traces", "policies"):
        shutil.rmtree(pair[1] / GROUP / folder)
    assert refusal(pair) == (
        f"{pair[1] / GROUP / 'single.csv'}: Run 1 differs from that in {pair[0] / GROUP / 'single.csv'}. "
        "Leave it out of one of them."
    )


def lose_a_trace(second: Path) -> str:
    path = sorted((second / GROUP / "traces").iterdir())[0]
    path.unlink()
    return (
        f"{path.parent}: The audit sample of run 0 in {GROUP}/single.csv needs the trace {path.name}, which "
        "is missing."
    )


def break_a_rule(second: Path) -> str:
    replace_in(second / "submission.toml", "format = 1", "format = 2")
    return f"{second}: The submission breaks the rule bad-value: submission.toml, format: The value is 2."


def rename_the_log(second: Path) -> str:
    (second / GROUP / "single.csv").rename(second / GROUP / "sequential.csv")
    return f"{second}: The submission breaks the rule "


@pytest.mark.parametrize("damage", [lose_a_trace, break_a_rule, rename_the_log])
def test_a_damaged_submission_is_refused(damage: Callable[[Path], str], pair: list[Path]) -> None:
    text = damage(pair[1])
    assert refusal(pair).startswith(text)


def test_a_folder_that_is_not_empty_is_refused(pair: list[Path]) -> None:
    before = digests(pair[0])
    with pytest.raises(BenchError) as error:
        joined(pair, pair[0])
    assert str(error.value) == f"{pair[0]}: The folder is not empty. Choose a folder that does not exist yet."
    assert digests(pair[0]) == before


def test_one_submission_is_refused(pair: list[Path], tmp_path: Path) -> None:
    with pytest.raises(BenchError, match=r"Expected two or more submissions, got 1\."):
        joined([pair[0], pair[0]], tmp_path / "merged")

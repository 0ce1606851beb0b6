"""``gym-extensions reproduce``: the same bytes, changed logs, and entries that cannot be retrained."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import pytest

from gym_extensions.__main__ import main
from gym_extensions.baselines import train
from gym_extensions.baselines.reproduction.draw import LoggedRun, draw_run
from gym_extensions.baselines.reproduction.reproduce import differing_versions
from gym_extensions.baselines.submission import manifest
from gym_extensions.installed import blas_kernels

from ..conftest import QUICK_GROUP, SHORT_GROUP, digests

Command = Callable[..., list[str]]


@pytest.fixture(scope="module")
def random_joint(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """random, joint, runs 0 and 1, with another number of environments than the budget's."""
    folder = tmp_path_factory.mktemp("submissions") / "random"
    train("random", QUICK_GROUP, "joint", "smoke", [0, 1], out=folder, num_envs=4, progress=False)
    return folder


@pytest.fixture
def command(quick_file: Path) -> Command:
    """The command for an entry; of the quick group by default."""

    def words(
        entry: Path, *, group: str = str(quick_file), protocol: str = "joint", run: int = 0
    ) -> list[str]:
        options = ("--group", group, "--protocol", protocol, "--run", str(run), "--quiet")
        return ["reproduce", str(entry), *options]

    return words


def test_a_run_of_trpo_is_the_same_bytes(
    trpo_submission: Path, command: Command, capsys: pytest.CaptureFixture[str]
) -> None:
    before = digests(trpo_submission)
    assert main(command(trpo_submission, group=SHORT_GROUP)) == 0
    assert capsys.readouterr().out == f"{trpo_submission} {SHORT_GROUP} joint run 0: the same bytes.\n"
    assert digests(trpo_submission) == before


def test_a_later_run_with_its_number_of_environments_is_the_same_bytes(
    random_joint: Path, command: Command, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(command(random_joint, run=1)) == 0
    assert capsys.readouterr().out.endswith("run 1: the same bytes.\n")


def changed(entry: Path, folder: Path, change: Callable[[float], float], episodes: int) -> Path:
    """A copy of an entry with changed returns of the first task, and another version of numpy."""
    copy = folder / "changed"
    shutil.copytree(entry, copy)
    log = copy / QUICK_GROUP.name / "joint.csv"
    header, *lines = log.read_text().splitlines()
    column = header.split(",").index("return")
    for index in range(episodes):
        cells = lines[index].split(",")
        cells[column] = repr(change(float(cells[column])))
        lines[index] = ",".join(cells)
    log.write_text("\n".join([header, *lines]) + "\n")
    return copy


def test_a_log_with_one_changed_return_agrees_and_the_row_is_named(
    random_joint: Path, command: Command, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copy = changed(random_joint, tmp_path, lambda value: value + 1, 1)
    assert main(command(copy)) == 0
    first, second, third = capsys.readouterr().out.splitlines()
    assert first.endswith("the mean returns of all 2 cells agree within evaluation noise.")
    assert second.startswith(
        f"The first difference is at stage 1, {QUICK_GROUP.task_ids[0]}, episode 0: return is "
    )
    assert third == "The versions, the platform and the BLAS kernels are those of the submission."


def test_a_log_with_another_mean_return_differs_and_the_cell_is_named(
    random_joint: Path, command: Command, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copy = changed(random_joint, tmp_path, lambda value: value + 500, 20)
    text = (copy / "submission.toml").read_text()
    (copy / "submission.toml").write_text(text.replace('platform = "', 'platform = "Plan9-'))
    assert main(command(copy)) == 1
    first, _, third, fourth, fifth = capsys.readouterr().out.splitlines()
    assert first.endswith("run 0: 1 of 2 cells differ.")
    assert third.startswith("The submission was made with platform Plan9-")
    assert fourth.startswith(f"Stage 1, {QUICK_GROUP.task_ids[0]}: mean return ")
    assert fifth == "With other versions or kernels it is another run of the agent, which refutes nothing."


def test_other_versions_of_the_agents_packages_are_named() -> None:
    tables = {"versions": manifest.versions(), "packages": {"pandas": "1.0", "torhc": "2.0"}}
    assert differing_versions(tables) == {"pandas": ("1.0", version("pandas")), "torhc": ("2.0", "none")}
    assert differing_versions({"versions": manifest.versions()}) == {}


def test_other_blas_kernels_are_named(
    random_joint: Path, command: Command, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copy = changed(random_joint, tmp_path, lambda value: value + 1, 1)
    text = (copy / "submission.toml").read_text()
    (copy / "submission.toml").write_text(re.sub('blas = ".*"', 'blas = "openblas Itanium"', text))
    assert main(command(copy)) == 0
    *_, third, fourth = capsys.readouterr().out.splitlines()
    assert third == f"The submission was made with blas openblas Itanium (installed: {blas_kernels()})."
    assert fourth == "OpenBLAS chooses its kernels by the variable OPENBLAS_CORETYPE, if it is set."


def test_a_manifest_without_blas_kernels_has_unknown_ones() -> None:
    versions = {name: value for name, value in manifest.versions().items() if name != "blas"}
    assert differing_versions({"versions": versions}) == {"blas": ("unknown", blas_kernels())}


REFUSED = [
    ('algorithm = "random"', 'algorithm = "mine"', "The algorithm 'mine' is not a reference agent."),
    ('steps = "recorded"', 'steps = "claimed"', "The policies were recorded, and the training was not"),
    ("num_envs = 4", "num_envs = 4\nlearning_rate = 0.1", "hyperparameters.learning_rate is 0.1 in this"),
]


@pytest.mark.parametrize("change", REFUSED, ids=["algorithm", "claimed", "hyperparameters"])
def test_an_entry_that_cannot_be_retrained_is_refused(
    change: tuple[str, str, str],
    random_joint: Path,
    command: Command,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    old, new, message = change
    copy = tmp_path / "entry"
    shutil.copytree(random_joint, copy)
    text = (copy / "submission.toml").read_text()
    assert old in text
    (copy / "submission.toml").write_text(text.replace(old, new))
    assert main(command(copy)) == 2
    assert capsys.readouterr().err.startswith(f"error: {copy / 'submission.toml'}: {message}")


def test_an_entry_of_another_agent_is_retrained_from_its_module(
    command: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "their_agent.py").write_text(
        "from gym_extensions.baselines.algorithms.random import make as Theirs\n"
    )
    entry = tmp_path / "entry"
    train("their_agent:Theirs", QUICK_GROUP, "joint", "smoke", 0, out=entry, progress=False)
    assert main([*command(entry), "--agent", "their_agent:Theirs"]) == 0
    assert capsys.readouterr().out.endswith("run 0: the same bytes.\n")
    assert main([*command(entry), "--agent", "zero"]) == 2
    assert "protocol.algorithm is 'random'" in capsys.readouterr().err


def test_a_salt_draws_the_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    entry = tmp_path / "random"
    train("random", SHORT_GROUP, "joint", "smoke", [0, 1], out=entry, num_envs=4, progress=False)
    salts = [f"{number:064x}" for number in range(8)]
    drawn = {salt: draw_run(entry, salt) for salt in salts}
    assert set(drawn.values()) == {LoggedRun(SHORT_GROUP, "joint", run) for run in (0, 1)}
    assert main(["reproduce", str(entry), "--salt", salts[0], "--quiet"]) == 0
    assert f"joint run {drawn[salts[0]].run}: the same bytes." in capsys.readouterr().out


def test_a_salt_can_draw_a_custom_group(
    random_joint: Path, quick_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["reproduce", str(random_joint), "--salt", f"{0:064x}", "--groups", str(quick_file), "--quiet"]
    assert main(command) == 0
    assert capsys.readouterr().out.endswith(": the same bytes.\n")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--salt", "abc"], "error: --salt: 'abc' is not 64 hexadecimal digits"),
        (["--salt", "0" * 64, "--run", "1"], "error: --salt: The salt draws the protocol and the run."),
    ],
    ids=["malformed", "with a run"],
)
def test_a_salt_that_cannot_draw_is_refused(
    options: list[str], message: str, random_joint: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["reproduce", str(random_joint), *options]) == 2
    assert capsys.readouterr().err.startswith(message)


def test_a_missing_entry_log_or_run_is_named(
    random_joint: Path, command: Command, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(command(tmp_path / "none")) == 2
    assert main(command(random_joint, protocol="single")) == 2
    assert main(command(random_joint, run=7)) == 2
    log = random_joint / QUICK_GROUP.name
    assert capsys.readouterr().err.splitlines() == [
        f"error: {tmp_path / 'none' / 'submission.toml'}: The file does not exist. "
        "Name the folder of a submission, such as submissions/random.",
        f"error: {log / 'single.csv'}: The log does not exist. Name a group and protocol of the entry.",
        f"error: {log / 'joint.csv'}: Run 7 is not in the log. Choose one of: 0, 1.",
    ]

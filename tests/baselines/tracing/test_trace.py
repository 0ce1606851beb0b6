"""The command trace: the sample of a salt, from stored traces or from the policies; what it refuses."""

from __future__ import annotations

import contextlib
import io
import re
import shutil
from pathlib import Path

import pytest

from gym_extensions.baselines import train
from gym_extensions.baselines.tracing import trace as trace_module
from gym_extensions.baselines.tracing.cli import main
from gym_extensions.baselines.tracing.trace import trace
from gym_extensions.errors import BenchError
from gym_extensions.installed import blas_kernels
from gym_extensions.scoring.replay.verify import verify

from ..conftest import SHORT_GROUP, digests

GROUP = "hopper-motor-noise"
"""The group of ``random_submission``."""
SALT, OTHER = "5a" * 32, "b7" * 32


def salt_file(folder: Path) -> Path:
    return folder / SHORT_GROUP / "traces" / "salt.txt"


@pytest.fixture(scope="module")
def salted(trpo_submission: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The deterministic agent's submission with the traces of a salt, and what the command printed."""
    ignore = shutil.ignore_patterns(".progress")
    folder = Path(shutil.copytree(trpo_submission, tmp_path_factory.mktemp("salted") / "trpo", ignore=ignore))
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        assert main([str(folder), "--salt", SALT]) == 0
    return folder, printed.getvalue()


def test_policies_repeat_the_episodes_of_a_salt(salted: tuple[Path, str], trpo_submission: Path) -> None:
    trpo, printed = salted
    assert re.fullmatch(rf"{SHORT_GROUP}: \d+ traces, drawn with the salt\.\n", printed)
    assert salt_file(trpo).read_text() == f"{SALT}\n"
    recorded = trpo_submission / ".progress" / SHORT_GROUP / "traces"
    drawn = [path for path in salt_file(trpo).parent.iterdir() if path.suffix == ".npz"]
    assert all(path.read_bytes() == (recorded / path.name).read_bytes() for path in drawn)
    before = {path.name for path in (trpo_submission / SHORT_GROUP / "traces").iterdir()}
    assert {path.name for path in drawn} != before
    verification = verify(trpo, salt=SALT)
    assert (verification.problems, verification.replayed) == ((), len(drawn))
    assert str(verification.level).startswith("replayed (salted sample: ")
    assert [problem.rule for problem in verify(trpo, salt=OTHER).problems] == ["other-salt"]


def test_without_a_salt_the_recorders_files_are_written_again(
    salted: tuple[Path, str], trpo_submission: Path, tmp_path: Path
) -> None:
    folder = Path(shutil.copytree(salted[0], tmp_path / "trpo"))
    before = digests(trpo_submission)
    assert digests(folder) != before
    trace(folder)
    assert digests(folder) == before


def refusal(folder: Path, salt: str = SALT) -> tuple[str, str]:
    before = digests(folder)
    with pytest.raises(BenchError) as error:
        trace(folder, salt)
    assert digests(folder) == before
    return error.value.code, error.value.message


def test_a_policy_that_gives_other_episodes_is_refused(random: Path) -> None:
    shutil.rmtree(random / ".progress")
    assert refusal(random) == ("policy-differs", "The stored policy gives another episode than the log.")


def test_a_lost_trace_without_a_policy_is_refused(random: Path) -> None:
    shutil.rmtree(random / ".progress")
    shutil.rmtree(random / GROUP / "policies")
    message = "The trace is not stored, and no stored policy can repeat it."
    assert refusal(random) == ("traces-lost", message)


def test_a_run_that_cannot_be_repeated_here_does_not_cost_the_others(
    trpo: Path, salted: tuple[Path, str]
) -> None:
    policies = trpo / SHORT_GROUP / "policies"
    joint = policies / "joint-run0-stage1.npz"
    original = joint.read_bytes()
    joint.write_bytes((policies / "sequential-run0-stage1.npz").read_bytes())
    with pytest.raises(BenchError) as error:
        trace(trpo, SALT)
    kept = {path.name for path in (trpo / ".progress" / SHORT_GROUP / "traces").iterdir()}
    expected = {path.name for path in salt_file(salted[0]).parent.glob("*.npz")}
    assert {name for name in expected if name.startswith("sequential-")} <= kept < expected
    assert error.value.hint == (
        "What could be repeated is kept in .progress. Restore the traces of all episodes in .progress."
    )
    assert not salt_file(trpo).exists()
    joint.write_bytes(original)
    for path in policies.glob("sequential-*.npz"):
        path.write_bytes(original)
    trace(trpo, SALT)
    assert {path.name for path in salt_file(trpo).parent.glob("*.npz")} == expected


def test_other_blas_kernels_than_those_of_the_log_are_named(trpo: Path) -> None:
    policies = sorted((trpo / SHORT_GROUP / "policies").glob("sequential-*.npz"))
    for path in policies:
        path.write_bytes((trpo / SHORT_GROUP / "policies" / "joint-run0-stage1.npz").read_bytes())
    text = (trpo / "submission.toml").read_text()
    (trpo / "submission.toml").write_text(re.sub('blas = ".*"', 'blas = "openblas Itanium"', text))
    with pytest.raises(BenchError) as error:
        trace(trpo, SALT)
    assert error.value.hint == (
        f"The same holds for {len(policies) - 1} more policies. What could be repeated is kept in .progress. "
        f"The log was made with the BLAS kernels openblas Itanium, and this process has {blas_kernels()}. "
        "Run the command again with those of the log, which OPENBLAS_CORETYPE can choose, or restore the "
        "traces of all episodes in .progress."
    )


def test_an_interrupted_call_keeps_what_it_repeated(
    trpo: Path, salted: tuple[Path, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    before = digests(trpo)
    with monkeypatch.context() as patch:
        patch.setattr(trace_module, "_replace", interrupted)
        with pytest.raises(KeyboardInterrupt):
            trace(trpo, SALT)
    assert digests(trpo) == before
    kept = {path.name for path in (trpo / ".progress" / SHORT_GROUP / "traces").iterdir()}
    assert kept == {path.name for path in salt_file(salted[0]).parent.glob("*.npz")}


def interrupted(*arguments: object) -> None:
    raise KeyboardInterrupt


def test_runs_can_be_added_after_the_traces_of_identical_runs_were_written_again(tmp_path: Path) -> None:
    folder = tmp_path / "quick"
    train("zero", GROUP, "single", "smoke", [0, 1], out=folder, progress=False)
    shutil.rmtree(folder / ".progress")
    trace(folder)
    train("zero", GROUP, "single", "smoke", [2], out=folder, progress=False)
    assert not verify(folder).problems


def test_a_salt_of_the_wrong_form_is_refused(trpo: Path) -> None:
    code, message = refusal(trpo, "5A" * 32)
    assert (code, message) == ("bad-salt", f"'{'5A' * 32}' is not 64 hexadecimal digits (0 to 9, a to f).")


def test_an_empty_salt_is_no_salt(random: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(random), "--salt", ""]) == 2
    assert "--salt: Expected 64 hexadecimal digits." in capsys.readouterr().err


def test_a_submission_with_problems_is_refused(trpo: Path) -> None:
    (trpo / "notes.txt").write_text("x")
    assert refusal(trpo) == ("not-valid", "The submission has problems: notes.txt: Unexpected file.")


def test_a_damaged_trace_is_written_again(trpo: Path) -> None:
    trace(trpo)
    before = digests(trpo)
    path = sorted((trpo / SHORT_GROUP / "traces").glob("*.npz"))[0]
    path.write_bytes(path.read_bytes()[:100])
    trace(trpo)
    assert digests(trpo) == before


def test_a_run_is_not_added_to_salted_traces(random: Path) -> None:
    trace(random, SALT)
    with pytest.raises(BenchError) as error:
        train("random", GROUP, "single", "smoke", [0, 1], out=random)
    assert error.value.code == "salted-traces"


def test_a_run_is_not_added_to_a_log_without_traces(random: Path) -> None:
    log = random / GROUP / "single.csv"
    rows = [line.split(",") for line in log.read_text().splitlines()]
    log.write_text("".join(",".join([*cells[:9], cells[10]]) + "\n" for cells in rows), newline="\n")
    with pytest.raises(BenchError) as error:
        train("random", GROUP, "single", "smoke", [0, 1], out=random)
    assert error.value.code == "unbound-log"

"""What was trained is taken from another job only if it follows from the merge. Boxes: tests/curation."""

import json
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest

from gym_extensions.baselines import Origin, cli, train
from gym_extensions.curation.cli import maintain
from gym_extensions.errors import BenchError
from gym_extensions.references import load_references
from gym_extensions.scoring.submission.scorer import score
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.review import Training, training_of, training_text
from gym_extensions.verification import train_here
from gym_extensions.verification.git import Repository

from ..baselines.conftest import digests
from ..conftest import refused
from ..curation.repositories import git, make_repository, merge
from .made_submissions import change_document, network

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="what a job wrote is read with limits")
GROUP, CODE = "pusher", "make = other = None\n"
RUN = f"{GROUP}/sequential/run0"
Change = Callable[[Path], object]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the repository ``main``, and ``trained`` of a job: two runs of an agent, by its seeds."""
    folder = tmp_path_factory.mktemp("made")
    submission = folder / "main/submissions/new"
    train("random", GROUP, "sequential", "smoke", 0, out=folder / "smoke")
    manifest = (folder / "smoke/submission.toml").read_text(encoding="utf-8")
    manifest += '\n[agent]\nentry = "agent.py:make"\n'
    make_repository(folder / "main")
    files = {"agent/agent.py": CODE, "submission.toml": manifest}
    merge(folder / "main", {f"submissions/new/{name}": text for name, text in files.items()})
    number, training = train_here.version_and_record(read(submission), "")
    assert number == 1
    origin = Origin(seeds=training.seeds)
    train("random", GROUP, "sequential", "smoke", [0, 1], out=folder / "trained/1", origin=origin)
    write(folder / "trained", training)
    return folder


def write(trained: Path, training: Training) -> None:
    (group,) = read(trained / "1").groups.values()
    found = msgspec.structs.replace(training, runs=group.digests("sequential"))
    (trained / "1.toml").write_text(training_text(found), encoding="utf-8")


@pytest.fixture
def folder(made: Path, tmp_path: Path, in_this_process: None, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(train_here, "STANDARD_BUDGET", "smoke")
    return Path(shutil.copytree(made, tmp_path / "made"))


def take(folder: Path, value: str = "") -> Path:
    submission = folder / "main/submissions/new"
    train_here.take(read(submission), folder / "trained", value)
    return submission


def test_runs_of_the_merged_code_are_taken_and_do_not_change(folder: Path) -> None:
    submission = take(folder)
    found = read(submission)
    assert found.problems == ()
    assert found.trained is not None
    merged = Repository(submission).fixed(submission, ["agent", "submission.toml"])
    assert (found.trained.version, found.trained.training.commit) == (1, merged)
    assert list(found.trained.training.runs) == [RUN, RUN.replace("run0", "run1")]
    assert not (submission / "trained/1/.progress").exists()
    before = {path: path.stat().st_mtime_ns for path in submission.glob("trained/1/*/*/*")}
    take(folder)
    assert {path: path.stat().st_mtime_ns for path in before} == before


def test_its_settings_are_those_of_the_code_and_the_cost_of_tuning_is_what_its_author_states(
    folder: Path,
) -> None:
    manifest = take(folder) / "submission.toml"
    text = manifest.read_text(encoding="utf-8").replace("steps = 0", "steps = 900")
    manifest.write_text(text.replace('algorithm = "random"', 'algorithm = "mine"'), encoding="utf-8")
    stated = score(read(manifest.parent), load_references()).manifest
    assert stated is not None
    assert stated.tuning is not None
    assert (stated.protocol.algorithm, stated.tuning.steps) == ("random", 900)


def test_a_run_that_was_finished_when_the_machine_died_is_taken(folder: Path) -> None:
    record = folder / "trained/1.toml"
    training = training_of(record.read_bytes())
    record.write_text(training_text(msgspec.structs.replace(training, runs={})), encoding="utf-8")
    assert len(training_of((take(folder) / "trained/1.toml").read_bytes()).runs) == 2


def test_runs_that_a_machine_left_without_a_record_are_replaced(folder: Path) -> None:
    left = folder / "main/submissions/new/trained/1"
    shutil.copytree(folder / "trained/1", left)
    change_document(left / f"{RUN}.json", cpu_seconds=1.0)
    found = read(take(folder)).trained
    assert found is not None
    assert {name: run.digest for name, run in found.runs.documents.items()} == found.training.runs


def record(**changes: object) -> Change:
    def change(trained: Path) -> None:
        path = trained / "1.toml"
        stated = msgspec.to_builtins(training_of(path.read_bytes())) | changes
        path.write_text(training_text(msgspec.convert(stated, Training)), encoding="utf-8")

    return change


def document(**changes: object) -> Change:
    return lambda trained: change_document(trained / f"1/{RUN}.json", **changes)


def other_seeds(trained: Path) -> None:
    document(command="gym-extensions train --seeds 1")(trained)
    write(trained, training_of((trained / "1.toml").read_bytes()))


REFUSED: dict[str, tuple[Change, str]] = {
    "no record": (lambda trained: (trained / "1.toml").unlink(), "not a record"),
    "a key of its own": (lambda trained: (trained / "1.toml").write_text("rank = 1\n"), "not a record"),
    "another commit": (record(commit="3f" * 20), "seeds do not follow"),
    "a value of its own": (record(value="3f" * 20), "seeds do not follow"),
    "other code": (record(agent="0" * 64), "seeds do not follow"),
    "another digest": (record(runs={RUN: "0" * 64}), "not those of the record"),
    "an edited document": (document(cpu_seconds=1.0), "not those of the record"),
    "seeds of its own": (other_seeds, "other seeds"),
    "an edited log": (lambda trained: (trained / f"1/{RUN}.csv").write_text("x\n"), f"{RUN}.csv"),
    "a file of its own": (lambda trained: (trained / "1/run.sh").write_text("x\n"), "Unexpected file"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_anything_else_is_refused_and_nothing_is_taken(folder: Path, name: str) -> None:
    change, reason = REFUSED[name]
    change(folder / "trained")
    with pytest.raises(BenchError, match=reason):
        take(folder)
    assert not (folder / "main/submissions/new/trained").exists()


def test_a_known_run_or_failure_is_not_changed(folder: Path) -> None:
    submission = take(folder)
    known = submission / "trained/1.toml"
    training = training_of(known.read_bytes())
    known.write_text(training_text(msgspec.structs.replace(training, failed={RUN: "x"})), encoding="utf-8")
    with pytest.raises(BenchError, match="a run that is known"):
        take(folder)


def test_a_public_value_is_part_of_the_seeds_and_stands(folder: Path) -> None:
    record(value="3f" * 20)(folder / "trained")
    with pytest.raises(BenchError, match="seeds"):
        take(folder, "4e" * 20)


def test_a_value_that_is_no_such_number_is_named_with_its_option(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert maintain(["train-here", str(tmp_path), "--value", "zz"]) == 2
    assert "--value: 'zz'" in capsys.readouterr().err


def test_code_that_no_merge_brought_is_not_due(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main = folder / "main"
    assert maintain(["train-here", str(main / "submissions"), "--due"]) == 0
    assert json.loads(capsys.readouterr().out) == ["new"]
    (main / "submissions/new/agent/agent.py").write_text(CODE + "# changed", encoding="utf-8")
    git(main, "commit", "-aqm", "directly")
    assert maintain(["train-here", str(main / "submissions"), "--due"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out) == []
    assert "new is left out: " in err
    assert "--value HEX" in err


def test_code_that_changed_is_the_next_version_and_due(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    submission = take(folder)
    merge(folder / "main", {"submissions/new/agent/agent.py": "make = 1\n"})
    number, training = train_here.version_and_record(read(submission), "")
    assert (number, training.runs) == (2, {})
    assert maintain(["train-here", str(submission), "--due"]) == 0
    assert capsys.readouterr().out == '["new"]\n'


def test_another_entry_of_the_same_code_is_the_next_version(folder: Path) -> None:
    text = (take(folder) / "submission.toml").read_text(encoding="utf-8")
    other = text.replace('"agent.py:make"', '"agent.py:other"')
    found = merge(folder / "main", {"submissions/new/submission.toml": other})
    number, training = train_here.version_and_record(read(folder / "main/submissions/new"), "")
    assert (number, training.commit) == (2, found)
    merge(folder / "main", {"submissions/new/submission.toml": f"# spelled better\n{other}"})
    assert train_here.version_and_record(read(folder / "main/submissions/new"), "")[1].commit == found


def test_half_a_run_is_due_again_and_a_broken_record_is_not_written_over(folder: Path) -> None:
    submission = take(folder)
    (submission / f"trained/1/{RUN}.csv").unlink()
    assert read(submission).problems
    assert train_here.version_and_record(read(submission), "")[0] == 1
    (submission / "agent/agent.py").write_text("make = 1\n", encoding="utf-8")
    assert train_here.is_due(read(submission), train_here.wanted_runs(5))
    (submission / "trained/1.toml").write_text("rank = 1\n", encoding="utf-8")
    assert not train_here.is_due(read(submission), train_here.wanted_runs(5))
    with pytest.raises(BenchError, match=r"trained/1\.toml"):
        train_here.version_and_record(read(submission), "")


def test_a_trial_changes_nothing_and_is_not_taken(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    submission, trial = folder / "main/submissions/new", folder / "trial"
    before = digests(submission)
    monkeypatch.setattr(train_here, "STANDARD_BUDGET", "300k")
    monkeypatch.setattr(cli, "isolated", lambda *_: "random")
    tried = train_here.train_here(read(submission), 1, groups=[GROUP], trial=trial)
    assert (list(tried.runs), (trial / f"1/{RUN}.csv").exists()) == ([RUN], True)
    assert digests(submission) == before
    assert train_here.is_due(read(submission), [RUN])
    with refused("bad-training", "the budget smoke"):
        train_here.take(read(submission), trial)


def test_a_withdrawn_submission_is_not_due(folder: Path) -> None:
    submission = folder / "main/submissions/new"
    wanted = train_here.wanted_runs(5)
    for decision, is_due in (("withdrawn", False), ("accepted", True)):
        assert (
            maintain(["decide", str(submission), decision, "--by", "N. N.", "--reason", "asked for it"]) == 0
        )
        assert train_here.is_due(read(submission), wanted) == is_due


BALANCED = {f"{GROUP}/balanced/run{run}" for run in (0, 1)}


def train_balanced(folder: Path, monkeypatch: pytest.MonkeyPatch, meanwhile: Change = id) -> Training:
    """Trains two balanced runs of an agent in the place of the code, and in no box."""
    submission = folder / "main/submissions/new"
    monkeypatch.setattr(cli, "isolated", lambda *_: (meanwhile(submission / "trained"), "random")[1])
    return train_here.train_here(read(submission), 2, protocol="balanced", groups=[GROUP])


def test_runs_in_another_order_are_trained_here_and_taken_and_are_not_the_core(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert train_balanced(folder, monkeypatch).runs.keys() == BALANCED
    submission = folder / "main/submissions/new"
    shutil.rmtree(folder / "trained")
    (submission / "trained").rename(folder / "trained")
    found = read(take(folder))
    assert not train_here.is_due(found, BALANCED)
    assert train_here.is_due(found, train_here.wanted_runs(1))
    card = score(found, load_references())
    (log,) = card.groups[f"{GROUP}-v0"].values()
    assert (card.level, log.level, log.runs, card.own) == ("trained here", "trained here", (0, 1), {})
    assert log.order_effects["final_performance"].shares


def test_a_record_keeps_what_another_command_adds_in_the_meantime(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    known = training_of((take(folder) / "trained/1.toml").read_bytes()).runs
    found = train_balanced(folder, monkeypatch, record(failed={RUN: "too late"}))
    assert (set(found.runs), found.failed) == (known.keys() | BALANCED, {RUN: "too late"})
    assert read(folder / "main/submissions/new").problems == ()


def test_an_unknown_group_is_refused_before_anything_is_trained() -> None:
    with refused("unknown-group", "pushr", "pusher"):
        train_here.wanted_runs(1, "balanced", ["pushr"])


def test_code_that_is_not_committed_has_no_seeds(folder: Path) -> None:
    submission = folder / "main/submissions/new"
    (submission / "agent/agent.py").write_text("make = 1\n", encoding="utf-8")
    with pytest.raises(BenchError, match="not committed"):
        train_here.version_and_record(read(submission), "")


@pytest.mark.parametrize(("head", "inputs"), [("deterministic", 5), ("gaussian", 21)])
def test_what_a_policy_raises_when_it_acts_is_an_error_of_its_agent(head: str, inputs: int) -> None:
    with pytest.raises(BenchError) as error:
        network(0, head).act(np.zeros((2, inputs)))
    assert error.value.code in train_here.AGENT_ERRORS


def test_a_submission_without_code_says_what_to_add(folder: Path) -> None:
    with refused("no-agent", "no code", "agent/"):
        train_here.version_and_record(read(folder / "smoke"), "")

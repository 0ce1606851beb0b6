"""A submission's folder: what can become one, the files of a run, locks, and what a full disk leaves."""

import errno
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import tomli_w

from gym_extensions.baselines import Card, Monitor, Observes, Origin, record, train
from gym_extensions.baselines.agent_spec import NO_FOLDER, AgentSpec
from gym_extensions.baselines.algorithms import names
from gym_extensions.baselines.submission import manifest_tables, read_manifest, require_same, validate
from gym_extensions.baselines.training.jobs import Settings
from gym_extensions.baselines.training.progress import Event, StageStarted
from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import budget
from gym_extensions.envs import fingerprinting
from gym_extensions.errors import BenchError
from gym_extensions.submissions.layout import MANIFEST
from gym_extensions.submissions.rules import problems
from gym_extensions.submissions.run import RunDocument, read_run

from ..conftest import refused
from .conftest import QUICK_GROUP, SHORT_GROUP, digests

GROUP = group(SHORT_GROUP)
SUBMISSIONS = Path(__file__).resolve().parents[2] / "submissions"
COMMITTED = {path.parent.name for path in SUBMISSIONS.glob(f"*/{MANIFEST}")}
NOTHING, CARD = Observes(), Card("climber", hyperparameters={"step": 0.1, "widths": [4, 4]}, stored_steps=10)
HOLD = """
import sys, time
from pathlib import Path
from gym_extensions.baselines.submission import lock_runs
with lock_runs(Path(sys.argv[1]), [sys.argv[2]]):
    print("held", flush=True)
    time.sleep(300)
"""


@pytest.mark.parametrize("name", ["zero run", "-zero", ".zero", "zéro", "z" * 65, "zero,2"])
def test_a_name_that_a_submission_cannot_have_is_rejected(name: str, tmp_path: Path) -> None:
    with refused("bad-out", repr(name)):
        validate(tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_the_folder_that_contains_submissions_is_rejected(random_submission: Path, tmp_path: Path) -> None:
    shutil.copytree(random_submission, tmp_path / "submissions/random")
    with refused("bad-out", "'random'"):
        validate(tmp_path / "submissions")


@pytest.mark.parametrize("inside", ["100k", "hopper-wall"])
def test_a_folder_inside_a_submission_is_rejected(
    inside: str, random_submission: Path, tmp_path: Path
) -> None:
    out = Path(shutil.copytree(random_submission, tmp_path / "mine"))
    with refused("bad-out", f"It is inside the submission {out}"):
        validate(out / inside)


@pytest.mark.parametrize("folder", ["poses", "landscapes"])
def test_a_run_can_join_a_reviewed_submission(folder: str, random_submission: Path, tmp_path: Path) -> None:
    out = Path(shutil.copytree(random_submission, tmp_path / "mine"))
    (out / folder).mkdir()
    validate(out)


@pytest.mark.parametrize("name", ["run0.csv", "run0.json"])
def test_a_damaged_run_is_named_before_training(name: str, random_submission: Path, tmp_path: Path) -> None:
    out = tmp_path / "mine"
    shutil.copytree(random_submission, out)
    path = next(out.rglob(name))
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(BenchError) as caught:
        validate(out)
    assert path.stem in caught.value.where


@pytest.mark.parametrize(("origin", "target"), [("balanced", "sequential"), ("sequential", "balanced")])
def test_a_run_in_the_place_of_another_order_is_named_first(origin: str, target: str, tmp_path: Path) -> None:
    out = tmp_path / "mine"
    train("zero", QUICK_GROUP, origin, "smoke", 1, out=out)
    (out / QUICK_GROUP.name / origin).rename(out / QUICK_GROUP.name / target)
    with refused("wrong-order", f"the document of {target} run 1"):
        train("zero", QUICK_GROUP, target, "smoke", 0, out=out)
    assert not (out / QUICK_GROUP.name / target / "run0.csv").exists()


def test_runs_with_a_lost_or_broken_manifest_are_rejected(random_submission: Path, tmp_path: Path) -> None:
    out = Path(shutil.copytree(random_submission, tmp_path / "mine"))
    (out / MANIFEST).write_text("title =\n")
    with refused("bad-manifest", "line 1"):
        train("zero", "hopper-motor-noise", "single", "smoke", 7, out=out)
    (out / MANIFEST).unlink()
    with refused("manifest-lost"):
        validate(out)


def settings(card: Card = CARD, observes: Observes = NOTHING, **changes: Any) -> Settings:
    return Settings(AgentSpec("climber", "mine:Climber", card, observes), budget("smoke"), **changes)


def test_a_new_manifest_passes_the_rules_and_reads_back_as_it_is() -> None:
    tables = manifest_tables(settings(observes=Observes(task_in_training=True), num_envs=4))
    assert [each.rule for each in problems("manifest", NO_FOLDER, tables)] == ["no-groups"]
    assert tables["hyperparameters"] == {"step": 0.1, "widths": [4, 4], "num_envs": 4}
    assert tables["observes"] == {"task_in_training": True, "task_in_evaluation": False, "boundaries": False}


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"observes": Observes(boundaries=True)}, "observes.boundaries is False"),
        ({"num_envs": 2}, "hyperparameters.num_envs is not stated"),
        ({"card": replace(CARD, algorithm="other")}, "protocol.algorithm is 'climber'"),
    ],
)
def test_a_run_of_another_setting_is_rejected(changes: dict[str, Any], named: str, tmp_path: Path) -> None:
    path, existing = tmp_path / MANIFEST, manifest_tables(settings())
    existing["protocol"].pop("parent", None)  # a key that may be left out
    path.write_text(tomli_w.dumps(existing), encoding="utf-8")
    with refused("mixed-submission", named):
        require_same(path, manifest_tables(settings(**changes)))
    assert require_same(path, manifest_tables(settings())) == existing


def test_another_engine_records_nothing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(fingerprinting, "engine", lambda: {"mujoco": "3.9.0", "gymnasium": "1.3.0"})
    with refused("other-engine", "gymnasium 1.3.0"):
        train("random", "pusher", "single", "smoke", 0, out=tmp_path / "mine")
    with refused("other-engine", "gymnasium 1.3.0"):
        record(print, "pusher", "joint", run=0, out=tmp_path / "mine", budget="smoke", card=CARD)
    assert list(tmp_path.iterdir()) == []


@pytest.fixture(scope="module")
def document(trpo_submission: Path) -> RunDocument:
    """The document of the sequential run of trpo."""
    return read_run(trpo_submission / SHORT_GROUP / "sequential/run0.json")


def test_the_document_says_how_the_run_was_trained(document: RunDocument) -> None:
    words = ["--groups", SHORT_GROUP, "--protocol", "sequential", "--budget", "smoke", "--runs", "0"]
    assert document.command.split() == ["gym-extensions", "train", "trpo", *words, "--out", "trpo"]
    assert 2000 <= document.steps <= 2000 * 1.02
    assert 0.1 < (document.cpu_seconds or 0) < 600
    assert 30 < (document.peak_memory_mb or 0) < 20_000
    assert document.machine and document.machine.cores == os.cpu_count()
    assert document.fingerprints == {task: published(task) for task in GROUP.task_ids}
    # Policy 23-64-64-7 and seven log σ; value function 23-64-64-1.
    parameters = 24 * 64 + 65 * 64 + 65 * 7 + 7 + 24 * 64 + 65 * 64 + 65
    assert document.memory.stored_steps == 250
    assert document.memory.parameters_first == document.memory.parameters_last == parameters


def test_every_stage_has_the_curves_of_its_tasks(trpo_submission: Path, document: RunDocument) -> None:
    trained = [(curve.stage, curve.task) for curve in document.curves]
    assert trained == [(1, GROUP.task_ids[0]), (2, GROUP.task_ids[1])]
    assert all(curve.steps[-1] <= 1000 * 1.02 for curve in document.curves)
    joint = read_run(trpo_submission / SHORT_GROUP / "joint/run0.json").curves
    assert [(curve.stage, curve.task) for curve in joint] == [(1, task) for task in GROUP.task_ids]
    assert all(1000 < curve.steps[-1] <= 2000 * 1.02 for curve in joint)


@pytest.fixture(scope="module")
def three_runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """random, joint, runs 0, 1 and 2 at once."""
    folder = tmp_path_factory.mktemp("three-runs") / "random"
    train("random", QUICK_GROUP, "joint", "smoke", [0, 1, 2], out=folder)
    return folder


def test_runs_of_two_machines_are_joined_by_copying_their_files(three_runs: Path, tmp_path: Path) -> None:
    for name, runs in (("here", [0]), ("there", [1, 2])):
        train("random", QUICK_GROUP, "joint", "smoke", runs, out=tmp_path / name / "random")
    shutil.copytree(tmp_path / "there/random", tmp_path / "here/random", dirs_exist_ok=True)
    assert digests(tmp_path / "here/random") == digests(three_runs)


def refuse_training(event: Event) -> None:
    assert not isinstance(event, StageStarted), "a finished stage was repeated"


@pytest.mark.parametrize("suffix", [".csv", ".npz"])
def test_a_full_disk_leaves_the_submission_as_it_was_and_the_run_can_be_written_later(
    suffix: str, three_runs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, write = tmp_path / "mine", Path.write_bytes

    def fill_disk(path: Path, content: bytes) -> int:
        if path.name.startswith(".run") and f"{suffix}." in path.name:
            write(path, content[:10])
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(path, content)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", fill_disk)
        with pytest.raises(BenchError) as error:
            train("random", QUICK_GROUP, "joint", "smoke", [0, 1, 2], out=out)
    assert error.value.message.count("No space left on device") == 3
    assert set(digests(out)) == ({MANIFEST} if suffix == ".csv" else set())  # another process may use it
    again = Monitor(callback=refuse_training)
    train("random", QUICK_GROUP, "joint", "smoke", [0, 1, 2], out=out, progress=again)
    assert digests(out) == digests(three_runs)


def test_a_run_that_another_process_trains_is_refused_until_that_process_ends(tmp_path: Path) -> None:
    out = tmp_path / "mine"
    command = [sys.executable, "-c", HOLD, str(out), f"{QUICK_GROUP.name} joint-run1"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "held\n"
        with refused("two-writers", "joint-run1"):
            train("zero", QUICK_GROUP, "joint", "smoke", [0, 1], out=out)
        assert not (out / QUICK_GROUP.name).exists()
        train("zero", QUICK_GROUP, "joint", "smoke", 0, out=out)
        process.kill()
    train("zero", QUICK_GROUP, "joint", "smoke", 1, out=out)
    assert len(list(out.rglob("run*.csv"))) == 2


def test_a_donated_run_adds_its_three_files_and_names_the_donor(three_runs: Path, tmp_path: Path) -> None:
    out = Path(shutil.copytree(three_runs, tmp_path / "random"))
    with (out / "submission.toml").open("a") as manifest:
        manifest.write("\n# a note of the author\n")
    before = digests(out)
    train("random", QUICK_GROUP, "joint", "smoke", 17, out=out, origin=Origin(by="A. Donor"))
    after = digests(out)
    assert {name: after[name] for name in before} == before
    added = sorted(Path(name).name for name in after.keys() - before.keys())
    assert added == ["run17.csv", "run17.json", "run17.npz"]
    names = {path.name: read_run(path).by for path in out.glob("*/joint/*.json")}
    assert names == {"run0.json": "", "run1.json": "", "run2.json": "", "run17.json": "A. Donor"}


@pytest.mark.committed
@pytest.mark.parametrize("name", sorted(COMMITTED & set(names()) - {"snapshots"}))  # it is assembled
def test_a_committed_submission_can_be_continued(name: str) -> None:
    if name.startswith(("ppo", "sac")):
        pytest.importorskip("sbx" if name in ("sac", "sac-fresh-buffer") else "stable_baselines3")
    path = SUBMISSIONS / name / MANIFEST
    existing = read_manifest(path)
    spec, chosen = AgentSpec.of(name, [(GROUP, "single")]), budget(existing["protocol"]["budget"])
    require_same(path, manifest_tables(Settings(spec, chosen, existing["hyperparameters"].get("num_envs"))))


def test_a_folder_that_is_not_writable_is_rejected(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    touch, out = Path.touch, tmp_path / "out"

    def refuse(path: Path, *arguments: Any, **options: Any) -> None:
        if path.is_relative_to(out):
            raise OSError(errno.EROFS, "Read-only file system")
        touch(path, *arguments, **options)

    monkeypatch.setattr(Path, "touch", refuse)
    with refused("bad-out", "Read-only file system"):
        train("zero", "hopper-motor-noise", "single", "smoke", 7, out=out)

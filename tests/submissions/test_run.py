"""The document of a run: what it holds, how it is written, and what verifications are about."""

from pathlib import Path

import msgspec
import pytest

from gym_extensions.catalog.groups import group
from gym_extensions.errors import BenchError
from gym_extensions.submissions import run as runs
from gym_extensions.submissions.submission import Submission, SubmittedGroup

from ..conftest import VERSIONS

PLAIN = runs.RunDocument(
    group="pusher-v0",
    protocol="joint",
    run=3,
    versions=VERSIONS,
    steps=1000,
    memory=runs.Memory(stored_steps=1, parameters_first=2, parameters_last=3),
    fingerprints={"task": "0" * 16},
    log="a" * 64,
)
FULL = msgspec.structs.replace(
    PLAIN,
    command="gym-extensions train ü",
    commit="abc",
    date="2026-11-26",
    packages={"torch": "2.13"},
    machine=runs.Machine(processor="Xeon", cores=2),
    cpu_seconds=1.5,
    peak_memory_mb=200.25,
    curves=[runs.Curve(stage=1, task=task, steps=[1, 2], returns=[0.1, -1e300]) for task in ("a", "b")],
    evaluations=[runs.InterimEvaluation(stage=1, task="a", episodes=5, steps=[1], returns=[2.0])],
    policies=runs.PolicyFile(sha256="b" * 64, size=10, url="https://example.org/run3.npz"),
)


@pytest.mark.parametrize("document", [PLAIN, FULL])
def test_a_document_is_read_as_it_was_written(tmp_path: Path, document: runs.RunDocument) -> None:
    runs.write_run(tmp_path / "run3.json", document)
    assert runs.read_run(tmp_path / "run3.json") == document


def test_a_number_that_is_not_finite_is_not_written() -> None:
    with pytest.raises(ValueError, match="JSON"):
        runs.run_text(msgspec.structs.replace(PLAIN, cpu_seconds=float("nan")))


@pytest.mark.parametrize(
    ("old", "new", "fact"),
    [
        ('"cpu_seconds"', '"cpu_second"', "cpu_second"),
        ('"run": 3', '"run": -1', r"\$.run"),
        ('"protocol": "joint"', '"protocol": "both"', r"\$.protocol"),
        ('"format": 1', '"format": 2', r"\$.format"),
        ('"log": "a', '"log": "A', r"\$.log"),
        ('"date": null', '"date": "yesterday"', r"\$.date"),
        ('"date": null', '"date": "2026-13-01"', r"\$.date"),
        ('"steps": 1000, ', "", "steps"),
    ],
)
def test_what_is_wrong_is_named_by_its_path(tmp_path: Path, old: str, new: str, fact: str) -> None:
    text = runs.run_text(PLAIN).replace(",\n", ", ")
    assert old in text
    (tmp_path / "run3.json").write_text(text.replace(old, new))
    with pytest.raises(BenchError, match=fact):
        runs.read_run(tmp_path / "run3.json")


def test_the_digest_is_about_the_document_the_log_and_the_policies() -> None:
    digest = FULL.digest
    assert digest.startswith("504fc60b09573716"), "reviews of committed submissions name digests of this form"
    changes = {"command": "", "curves": [], "steps": 1, "log": "c" * 64, "policies": None}
    assert digest not in {msgspec.structs.replace(FULL, **{key: new}).digest for key, new in changes.items()}
    assert runs.run_of(runs.run_text(FULL).encode()).digest == digest
    other = runs.PolicyFile(sha256="b" * 64, size=99)  # packed anew, and elsewhere
    assert msgspec.structs.replace(FULL, policies=other).digest == digest


def test_memory_of_several_runs() -> None:
    memory = runs.Memory(stored_steps=9, parameters_first=1, parameters_last=3)
    other = msgspec.structs.replace(FULL, memory=memory)
    documents = {"joint": dict(enumerate([PLAIN, other, FULL]))}
    submission = Submission("submission", None, {"pusher-v0": SubmittedGroup(group("pusher"), {}, documents)})
    assert submission.memory == runs.Memory(stored_steps=9, parameters_first=2, parameters_last=3)
    assert Submission("submission", None, {}).memory is None

"""Submissions of the form before every run had its own files, moved to the form of today."""

from __future__ import annotations

import hashlib
import importlib.util
import json
import sys
import tomllib
from itertools import product
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.protocol import BUDGETS, evaluation_seed
from gym_extensions.rollouts.policy import Policy
from gym_extensions.rollouts.reader import read
from gym_extensions.rollouts.review import VERIFIED, level, read_review
from gym_extensions.rollouts.run import file_sha256, read_run
from gym_extensions.rollouts.run_policies import content_sha256, npz_bytes, policy_keys, read_arrays

from .conftest import MANIFEST, UNIFORM

SCRIPT = Path(__file__).parents[1] / "scoring" / "migrate_format_1.py"
HOPPER = group("hopper-gravity")
COMMANDS = (
    "A formula. Made by: gym-extensions train formula --groups hopper-gravity --protocol sequential "
    "--runs 0-1 --out submissions/old, then gym-extensions train formula --groups hopper-gravity "
    "--protocol single --runs 0 --out single/old and the same with --runs 1 --out single1/old "
    "(at commit 8d8eecb6), and joined by gym-extensions merge"
)
SECTIONS = """
[memory]
stored_steps = 2000
parameters_first = 100
parameters_last = 100

[versions]
gym_extensions = "1.0.0.dev0"
gymnasium = "1.4.0"
mujoco = "4.0.0"
numpy = "2.4.6"
python = "3.11.7"
platform = "Linux-x86_64"

[traces]
root = "00"
"""
RETURNS = (0.1, -1e-17, 123456.789e-3)


@pytest.fixture(scope="module")
def migration() -> ModuleType:
    """The script."""
    spec = importlib.util.spec_from_file_location("migrate_format_1", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # which dataclasses look up
    spec.loader.exec_module(module)
    return module


def returned(protocol: str, run: int, stage: int, position: int, episode: int) -> str:
    return repr(RETURNS[(run + stage + position) % 3] + episode + (0.5 if protocol == "single" else 0))


def old_rows(protocol: str, run: int) -> list[str]:
    """The rows of a run in the old log."""
    stages = range(6) if protocol == "sequential" else (1,)
    return [
        f"{run},{stage},{task.id},{episode},{evaluation_seed(HOPPER.id, task.id, episode)},1000,"
        f"{returned(protocol, run, stage, position, episode)},false,,{'0' * 32},{published(task.id)}"
        for stage, (position, task), episode in product(stages, enumerate(HOPPER.tasks), range(20))
    ]


def write_old(root: Path, *, description: str = COMMANDS, policies: bool = True) -> Path:
    """An entry of the old form."""
    folder = root / "submissions" / "old"
    place = folder / HOPPER.name
    (place / "policies").mkdir(parents=True)
    (place / "traces").mkdir()
    (place / "traces" / "sequential-run0-stage1-HopperGravityHalf-episode3.npz").write_bytes(b"")
    header = "run,stage,task,episode,seed,length,return,terminated,success,trace,fingerprint"
    curves = ["protocol,run,task,step,return"]
    for protocol in ("sequential", "single"):
        rows = [row for run in (0, 1) for row in old_rows(protocol, run)]
        (place / f"{protocol}.csv").write_text("\n".join([header, *rows, ""]))
        for run, task, step in product((0, 1), HOPPER.task_ids, (10, 20)):
            curves.append(f"{protocol},{run},{task},{step},{step / 3!r}")
        for run, (stage, task_name) in product((0, 1), policy_keys(protocol, HOPPER)):
            ending = "" if task_name is None else f"-{task_name}"
            policy = Policy(np.full(3, 0.5), np.ones(3), head="uniform") if run else UNIFORM
            if policies:
                path = place / "policies" / f"{protocol}-run{run}-stage{stage}{ending}.npz"
                path.write_bytes(npz_bytes(policy.arrays()))
    (place / "curves.csv").write_text("\n".join([*curves, ""]))
    columns = "protocol,run,stage,task,step,episodes,return"
    row = f"sequential,0,2,{HOPPER.task_ids[0]},10,5,0.25"
    (place / "evaluations.csv").write_text(f"{columns}\n{row}\n")
    text = MANIFEST.replace("Made up by a formula.", description).replace('commit = ""', 'commit = "abc"')
    (folder / "submission.toml").write_text(text + SECTIONS)
    return folder


def files(folder: Path) -> dict[str, bytes]:
    paths = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}


def test_every_cell_and_every_curve_is_kept(migration: ModuleType, tmp_path: Path) -> None:
    folder = write_old(tmp_path)
    assert migration.main([str(folder)]) == 0
    submission = read(folder, policies=True)
    assert submission.problems == ()
    (submitted,) = submission.groups.values()
    for protocol, log in submitted.logs.items():
        old = [row.split(",") for run in (0, 1) for row in old_rows(protocol, run)]
        assert log.run.tolist() == [int(cells[0]) for cells in old]
        assert log.return_.tolist() == [float(cells[6]) for cells in old]
        path = folder / HOPPER.name / protocol / "run1.csv"
        rows = [",".join(row.split(",")[1:9]) for row in old_rows(protocol, 1)]
        assert path.read_text().splitlines()[1:] == rows
        assert [value for *_, value in (row.split(",") for row in rows)] == [""] * len(rows)
    documents = [document for runs in submitted.runs.values() for document in runs.values()]
    curves = [curve for document in documents for curve in document.curves]
    assert [curve.returns for curve in curves] == [[10 / 3, 20 / 3]] * 20
    assert [curve.stage for curve in documents[0].curves] == [1, 2, 3, 4, 5]
    assert [part.task for document in documents for part in document.evaluations] == [HOPPER.task_ids[0]]


def test_the_document_says_what_is_known_and_nothing_else(migration: ModuleType, tmp_path: Path) -> None:
    folder = write_old(tmp_path)
    migration.main([str(folder)])
    sequential, single = (
        read_run(folder / HOPPER.name / name / "run1.json") for name in ("sequential", "single")
    )
    assert sequential.command.endswith("--protocol sequential --runs 0-1 --out submissions/old")
    assert single.command.endswith("--protocol single --runs 1 --out single1/old")
    assert (sequential.commit, single.commit) == ("abc", "8d8eecb6")
    assert (sequential.machine, sequential.cpu_seconds, sequential.peak_memory_mb, sequential.date) == (
        None,
    ) * 4
    assert sequential.steps == 5 * BUDGETS["smoke"].steps_for(HOPPER.name)
    assert sequential.fingerprints == {task: published(task) for task in HOPPER.task_ids}
    assert sequential.memory.parameters_last == 100
    assert sequential.log == file_sha256(folder / HOPPER.name / "sequential" / "run1.csv")
    assert sequential.policies is not None
    assert sequential.policies.sha256 == content_sha256(read_arrays(folder, HOPPER, "sequential", 1))
    tables = tomllib.loads((folder / "submission.toml").read_text())
    assert tables["description"] == "A formula."
    assert not {"memory", "versions", "traces"} & set(tables)
    assert not (folder / "README.md").exists()


def test_old_files_go_but_policies_and_traces_stay(migration: ModuleType, tmp_path: Path) -> None:
    folder = write_old(tmp_path)
    migration.main([str(folder)])
    names = {path.name for path in (folder / HOPPER.name).iterdir()}
    assert names == {"sequential", "single", "policies", "traces"}


def test_it_can_be_run_again_and_gives_the_same_everywhere(migration: ModuleType, tmp_path: Path) -> None:
    first, second = write_old(tmp_path / "a"), write_old(tmp_path / "b")
    migration.main([str(first)])
    before = files(first)
    migration.main([str(first)])
    migration.main([str(second)])
    assert files(first) == before == files(second)


def test_policies_are_repacked_without_a_change_of_their_digest(
    migration: ModuleType, tmp_path: Path
) -> None:
    folder = write_old(tmp_path)
    migration.main([str(folder)])
    digest = read_run(folder / HOPPER.name / "single" / "run1.json").digest
    assert migration.main([str(folder), "--repack-policies", "--drop-traces"]) == 0
    assert {path.name for path in (folder / HOPPER.name).iterdir()} == {"sequential", "single"}
    document = read_run(folder / HOPPER.name / "single" / "run1.json")
    assert document.digest == digest
    assert document.policies is not None
    assert document.policies.size == (folder / HOPPER.name / "single" / "run1.npz").stat().st_size
    assert read(folder, policies=True).problems == ()


def test_commands_that_do_not_name_a_run_stay_in_the_readme(migration: ModuleType, tmp_path: Path) -> None:
    text = (
        "A formula. Made by: gym-extensions train formula --groups hopper-gravity --protocol single --runs 0"
    )
    folder = write_old(tmp_path, description=text)
    migration.main([str(folder)])
    assert read_run(folder / HOPPER.name / "sequential" / "run0.json").command == ""
    assert text in (folder / "README.md").read_text()


def test_an_entry_without_policies_is_claimed(migration: ModuleType, tmp_path: Path) -> None:
    folder = write_old(tmp_path, policies=False)
    assert migration.main([str(folder)]) == 0
    assert read_run(folder / HOPPER.name / "single" / "run0.json").policies is None
    assert "no policies of run 0, 1" in read(folder).groups[HOPPER.id].notes[0]


def write_evidence(folder: Path, digest: str) -> None:
    """The ledger and the records of a re-evaluation and a repetition, about the files of a digest."""
    line = {"entry": "old", "date": "2026-11-24", "event": "accepted", "level": "re-evaluated"}
    line |= {"reason": "Five runs.", "scorer": "1.0.0.dev0"}
    (folder.parent / "ledger.jsonl").write_text(
        json.dumps(line) + "\n" + json.dumps(line | {"entry": "other"}) + "\n"
    )
    records = folder.parent.parent / "scoring"
    cells = [{"run": run, "stage": 1} for run in range(6)]
    seeds = {"digest": digest, "salt": "ab" * 32, "p_value": 0.25}
    record = {
        "is_complete": True,
        "new_seeds": seeds,
        "groups": {HOPPER.id: {"sequential": {"cells": cells}}},
    }
    (records / "reevaluations").mkdir(parents=True)
    (records / "reevaluations" / "old.json").write_text(json.dumps(record))
    place = folder / HOPPER.name
    rows = "".join(f"{row}\n" for row in old_rows("sequential", 1)).encode()
    paths = sorted((place / "policies").glob("sequential-run1-*"))
    hashes = [hashlib.sha256(data).hexdigest() for data in (rows, *(path.read_bytes() for path in paths))]
    run_digest = hashlib.sha256("".join(f"{each}\n" for each in hashes).encode()).hexdigest()
    run = {"group": HOPPER.id, "protocol": "sequential", "episodes": 600, "blas": "openblas Haswell"}
    runs = [run | {"run": 1, "digest": run_digest}, run | {"run": 0, "digest": "0" * 64}]
    (records / "repetitions").mkdir()
    (records / "repetitions" / "old.json").write_text(json.dumps({"runs": runs}))


def test_evidence_about_these_files_becomes_a_review(migration: ModuleType, tmp_path: Path) -> None:
    folder = write_old(tmp_path)
    write_evidence(folder, migration.digest_of_old_entry(folder))
    assert migration.main([str(folder)]) == 0
    review = read_review(folder)
    (verification,) = review.verifications
    assert (verification.cells, verification.p_value, verification.value) == (6, 0.25, "ab" * 32)
    assert (verification.episodes, verification.repeated) == (600, 600)
    assert verification.kernels == "openblas Haswell"
    assert [(each.action, each.date, each.reason) for each in review.decisions] == [
        ("accepted", "2026-11-24", "Five runs.")
    ]
    (submitted,) = read(folder).groups.values()
    assert level(review, submitted.digests("sequential")) == VERIFIED
    before = files(folder)
    migration.main([str(folder), "--repack-policies"])
    assert files(folder)["review.toml"] == before["review.toml"]


def test_evidence_about_other_files_is_dropped(migration: ModuleType, tmp_path: Path) -> None:
    folder = write_old(tmp_path)
    write_evidence(folder, "0" * 64)
    migration.main([str(folder)])
    review = read_review(folder)
    assert review.verifications == []
    assert len(review.decisions) == 1


def test_verifications_of_before_can_be_left_out(migration: ModuleType, tmp_path: Path) -> None:
    folder = write_old(tmp_path)
    write_evidence(folder, migration.digest_of_old_entry(folder))
    assert migration.main([str(folder), "--decisions-only"]) == 0
    review = read_review(folder)
    assert (len(review.verifications), len(review.decisions)) == (0, 1)

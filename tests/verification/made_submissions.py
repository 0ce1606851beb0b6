"""Small honest submissions: networks with drawn weights, and the episodes that they have on this machine."""

import shutil
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from gym_extensions.catalog.groups import GROUPS, TaskGroup, group as group_of
from gym_extensions.catalog.protocol import BUDGETS, EVALUATION_EPISODES, evaluation_seed, stages
from gym_extensions.submissions import run as documents
from gym_extensions.submissions.layout import POLICIES, run_file
from gym_extensions.submissions.log import Episode, read_log, write_log
from gym_extensions.submissions.policies import files
from gym_extensions.submissions.policies.mlp import Policy
from gym_extensions.submissions.policies.onnx import OnnxPolicy
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.review import level
from gym_extensions.verification.cli import main
from gym_extensions.verification.episodes import Cell, run_cell
from gym_extensions.versions import version

from ..conftest import MANIFEST, write_run

GROUP = "hopper-wall"
RUNS = (0, 1, 2, 3, 4)
VALUE = "3f" * 20
"""From it, the seeds of ``verify`` are drawn."""
SCRATCH = tempfile.TemporaryDirectory(prefix="submissions-")
CACHE = Path(SCRATCH.name, "cache")
"""Episodes that another test has run with the same policies on the same seeds."""
ONNX = "onnx"
"""In place of a head: the same policies as ONNX networks, which need torch and the extra ``onnx``."""
Row = dict[str, Any]


def network(seed: int, head: str = "deterministic", actions: int = 3, inputs: int = 21) -> Policy:
    """A linear policy with drawn weights."""
    rng = np.random.default_rng(seed)
    return Policy(
        action_offset=np.zeros(actions),
        action_scale=np.ones(actions),
        weights=(rng.normal(0, 0.5, (inputs, actions)),),
        biases=(rng.normal(0, 0.5, actions),),
        squash="tanh",
        head=head,
        log_sigma=np.full(actions, -0.5) if head == "gaussian" else None,
    )


def write_run_files(
    folder: Path,
    protocol: str,
    run: int,
    policies: Mapping[files.Key, files.AnyPolicy],
    played: Mapping[files.Key, files.AnyPolicy] | None = None,
) -> None:
    """Writes the log, the document and the policies of a run; ``played`` are those whose episodes it logs."""
    members = group_of(GROUP)
    episodes = []
    for stage in stages(protocol, len(members.tasks)):
        for index, task in enumerate(members.tasks):
            seeds = tuple(evaluation_seed(members.id, task.id, each) for each in range(EVALUATION_EPISODES))
            policy = (played or policies)[stage, task.name if protocol == "single" else None]
            noise = None if policy.head == "deterministic" else 1000 * run + 10 * stage + index
            outcomes = run_cell(members, policy, Cell(stage, index, seeds, noise))
            episodes += [
                Episode(stage, task.id, number, seed, *outcome)
                for number, (seed, outcome) in enumerate(zip(seeds, outcomes, strict=True))
            ]
    names = ("gym_extensions", "gymnasium", "mujoco", "numpy")
    versions = {name: version(name.replace("_", "-")) for name in names} | {"python": "3.11.0"}
    write_run(
        *(folder, members, protocol, run, episodes),
        policies=policies,
        versions=documents.Versions(**versions, platform="Linux-x86_64"),
        steps=BUDGETS["100k"].steps_for(GROUP) * len(members.tasks),
        memory=documents.Memory(stored_steps=0, parameters_first=36, parameters_last=36),
    )


def write_submission(
    folder: Path, head: str = "deterministic", protocol: str = "sequential", runs: int = len(RUNS)
) -> Path:
    """Writes an honest submission, by default of five runs."""
    folder.mkdir(parents=True)
    for run in range(runs):
        keys = files.policy_keys(protocol, group_of(GROUP))
        policies: dict[files.Key, files.AnyPolicy] = {}
        for number, key in enumerate(keys):
            seed = 100 * run + number
            is_onnx = head == ONNX
            policies[key] = OnnxPolicy(network(seed).to_onnx()) if is_onnx else network(seed, head)
        write_run_files(folder, protocol, run, policies)
    evaluation = "deterministic" if head in ("deterministic", ONNX) else "sampled"
    text = MANIFEST.replace('"smoke"', '"100k"').replace('"sampled"', f'"{evaluation}"')
    (folder / "submission.toml").write_text(text, encoding="utf-8", newline="\n")
    return folder


def honest(head: str = "deterministic", runs: int = len(RUNS)) -> Path:
    """An honest submission, made once per process. It must not be changed."""
    folder = Path(SCRATCH.name, f"{head}-{runs}", "honest")
    return folder if folder.exists() else write_submission(folder, head, runs=runs)


def copy(submission: Path, target: Path) -> Path:
    """A copy of a submission that may be changed."""
    return Path(shutil.copytree(submission, target))


def verify(submission: Path, *options: str) -> int:
    """The exit status of the command on a submission, with its cache beside it."""
    return main([str(submission), "--seeds", VALUE, "--cache", str(submission.parent / "cache"), *options])


def level_of(submission: Path, groups: Mapping[str, TaskGroup] = GROUPS) -> str:
    """The level of the only sequential log of a submission without problems."""
    found = read(submission, groups, policies=True)
    assert found.problems == ()
    (submitted,) = found.groups.values()
    assert found.manifest is not None
    return level(found.review, found.manifest.digest, submitted.digests("sequential"))


def change_log(submission: Path, edit: Callable[[Row], Mapping[str, object]], run: int | None = None) -> Path:
    """Changes rows of the logs of all runs or of one, and states the new digests."""
    success = {1: True, 0: False, -1: None}
    for path in sorted(submission.glob("*/*/run*.csv")):
        if run is not None and path.stem != f"run{run}":
            continue
        episodes, rows = [], read_log(path)
        for each in rows.to_dict("records"):
            row: Row = {**each, **edit(each)}  # type: ignore[arg-type, dict-item]
            end = {"return_": float(row.pop("return")), "success": success[row["success"]]}
            episodes.append(Episode(**row | end))
        write_log(path, episodes, tuple(rows["task"].unique()))
        change_document(path.with_suffix(".json"), log=documents.file_sha256(path))
    return submission


def change_document(path: Path, **changes: object) -> None:
    """Changes values of a run's document."""
    documents.write_run(path, msgspec.structs.replace(documents.read_run(path), **changes))


def change_documents(submission: Path, change: Callable[..., Mapping[str, object]]) -> None:
    """Changes values of the documents of all runs, which ``change`` gets."""
    for path in sorted(submission.glob("*/*/*.json")):
        change_document(path, **change(documents.read_run(path)))


def change_policies(submission: Path, change: Callable[[dict[files.Key, files.AnyPolicy]], object]) -> None:
    """Changes the stored policies of all runs, and states their digests."""

    def changed(run: documents.RunDocument) -> Mapping[str, object]:
        stored = files.read_policies(submission, group_of(GROUP), run.protocol, run.run)
        change(stored)
        path = submission / run_file(GROUP, run.protocol, run.run, POLICIES)
        files.write_policies(path, stored)
        digest = files.content_sha256(files.run_arrays(stored))
        return {"policies": documents.PolicyFile(sha256=digest, size=path.stat().st_size)}

    change_documents(submission, changed)

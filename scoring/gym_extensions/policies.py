"""Policies of submissions: loads them, converts them from and to PyTorch and ONNX, and diagnoses networks.

Example:
    >>> from gym_extensions import policies
    >>> policy = policies.load("submissions/trpo", "hopper-gravity", run=0, stage=5)  # doctest: +SKIP
    >>> policy.act(observation)  # doctest: +SKIP

Plain arrays need no extra, networks the extra ``onnx``. Experts are such policies, too
(:func:`gym_extensions.references.experts.load`).
"""

from collections.abc import Sequence
from pathlib import Path

from gym_extensions.catalog.groups import TaskGroup, resolve_group
from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.catalog.states import states
from gym_extensions.errors import BenchError, did_you_mean, require_known
from gym_extensions.submissions import fetch, layout
from gym_extensions.submissions.policies import diagnostics, files, mlp_arrays
from gym_extensions.submissions.policies.conversion import from_torch
from gym_extensions.submissions.policies.diagnostics import Diagnosis
from gym_extensions.submissions.policies.mlp import Policy
from gym_extensions.submissions.policies.onnx import OnnxPolicy
from gym_extensions.submissions.run import PolicyFile, read_run
from gym_extensions.submissions.submission import runs_folder

__all__ = ["Diagnosis", "OnnxPolicy", "Policy", "diagnose", "from_torch", "load"]


def load(
    source: str | Path,
    group: str | Path | TaskGroup,
    *,
    run: int = 0,
    stage: int | None = None,
    task: str | None = None,
    protocol: str = "sequential",
    sha256: str = "",
) -> files.AnyPolicy:
    """A policy of a run, whose ``act(observation)`` takes one observation or many.

    Args:
        source: the folder of a submission, whose policies may be stored elsewhere; or the address of a run's
            .npz file, which is fetched into a cache.
        group: the name of a group, the TOML file of a custom group, or a group.
        run: the number of the run.
        stage: how many tasks the policy was trained on; the last stage if None.
        task: in the protocol ``single``, the trained task.
        protocol: ``sequential``, ``single`` or another one (docs/concepts.md).
        sha256: the digest of the content, ``policies.sha256`` of the run's document. An address needs it.

    Raises:
        BenchError: there is no such submission, run, stage or task, the policies cannot be read, or they do
            not match the digest.
    """
    members = resolve_group(group)
    require_known("protocol", protocol, PROTOCOLS, "protocol")
    keys = files.policy_keys(protocol, members)
    key = (keys[-1][0] if stage is None else stage, task)
    if key not in keys:
        each = "a stage and a task" if protocol == "single" else "a stage and no task"
        hint = f"The protocol {protocol} has {each}; stages are {keys[0][0]} to {keys[-1][0]}."
        if task is not None and protocol == "single":
            hint = did_you_mean(task, [name for _, name in keys if name])
        raise BenchError("unknown-policy", f"There is no policy of stage {key[0]}, task {task}.", "", hint)
    if "://" not in str(source):
        arrays = _of_submission(Path(source), members, protocol, run)
        if sha256:
            files.require_digest(arrays, sha256, str(source))
    elif sha256:
        arrays = _fetched(PolicyFile(sha256=sha256, size=0, url=str(source)))
    else:
        hint = "Pass sha256, which the run's document states under policies."
        raise BenchError("no-digest", "An address needs a digest.", str(source), hint)
    return files.policies_of(arrays, members, protocol)[key]


def diagnose(
    policies: Sequence[files.AnyPolicy], observations: str | Path | TaskGroup | Sequence[mlp_arrays.Array]
) -> tuple[Diagnosis, ...]:
    """What training did to the networks of an agent: ranks, inactive units, and what changed since each task.

    Args:
        policies: the untrained policy, then that after each task, in the order of the tasks.
        observations: a group, whose published observations are taken; or those of each task, (n, …).

    Raises:
        BenchError: the observations do not fit a policy, or none are published of the group.

    Example:
        >>> stages = [load("mine", "hopper-wall", stage=stage) for stage in range(3)]  # doctest: +SKIP
        >>> pd.DataFrame(diagnose(stages, "hopper-wall"))  # doctest: +SKIP
    """
    if isinstance(observations, str | Path | TaskGroup):
        group = resolve_group(observations)
        known = states(group.task_ids)
        if known is None:
            hint = "Pass the observations of each of its tasks, an array (n, …) per task."
            raise BenchError("no-states", f"No observations of {group.name} are published.", "", hint)
        observations = known
    if isinstance(policies, files.AnyPolicy) or not 0 < len(policies) <= len(observations) + 1:
        message = f"There are observations of {len(observations)} tasks."
        hint = "Pass a list: the untrained policy, then that after each task, in order."
        raise BenchError("bad-argument", message, "diagnose()", hint)
    if not all(map(len, observations)):
        raise BenchError("no-states", "A task has no observations.", "diagnose()", "Pass some of each task.")
    return diagnostics.diagnose(policies, observations)


def _of_submission(folder: Path, group: TaskGroup, protocol: str, run: int) -> mlp_arrays.Arrays:
    runs = runs_folder(folder, group.name, protocol)
    path = runs / layout.run_file(group.name, protocol, run, layout.DOCUMENT)
    if not path.is_file():
        found = f"{folder} has no run {run} of {group.name}, {protocol}."
        message = found if folder.is_dir() else f"There is no folder {folder}."
        raise BenchError("no-such-run", message, str(path), "Name a submission and one of its runs.")
    stated = read_run(path).policies
    if stated is None:
        raise BenchError("no-policies", "The run publishes no policies.", str(path), "Choose another run.")
    if stated.url:
        return _fetched(stated)
    arrays = files.read_arrays(runs, group, protocol, run)
    files.require_digest(arrays, stated.sha256, str(path))
    return arrays


def _fetched(policies: PolicyFile) -> mlp_arrays.Arrays:
    path = fetch.Fetcher(fetch.cache_folder() / "policies").fetch(policies, policies.url)
    return fetch.read_copy(path, policies.sha256, policies.url)

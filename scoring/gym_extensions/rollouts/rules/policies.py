"""Rules about policy files: their arrays, and that a log has the policies of all its runs and stages."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import PROTOCOLS, stages
from gym_extensions.rollouts.layout import POLICIES, POLICY, policy_names
from gym_extensions.rollouts.policies import Policy
from gym_extensions.rollouts.policies.checks import array_errors
from gym_extensions.rollouts.problem import Finding
from gym_extensions.rollouts.reading.evaluation_log import Runs
from gym_extensions.rollouts.rules.npz import ArrayFile
from gym_extensions.rollouts.rules.rule import rule

WRITE = "Write it with gym_extensions.rollouts.policies.Policy.to_bytes."


@dataclass(frozen=True)
class PolicyFile:
    """The path and the arrays of a policy file; None if the file cannot be read."""

    path: str
    arrays: Mapping[str, NDArray[Any]] | None


@dataclass(frozen=True)
class PolicySummary:
    """What the policies of a group are compared by.

    ``num_inputs`` is None for a policy that uses no observations; ``num_tasks`` is 0 without arrays per task.
    """

    num_inputs: int | None
    num_actions: int
    num_tasks: int
    head: str

    @classmethod
    def of(cls, policy: Policy) -> PolicySummary:
        """The summary of a policy."""
        return cls(policy.num_inputs, len(policy.action_offset), policy.num_tasks, policy.head)


@dataclass(frozen=True)
class GroupPolicies:
    """The policies of a group.

    ``summaries`` are the valid policies by path, ``names`` all file names. ``runs`` are the runs of each log.
    ``observes_task`` and ``evaluation`` are those of the manifest. What is unknown is None.
    """

    group: TaskGroup
    names: frozenset[str]
    summaries: Mapping[str, PolicySummary]
    runs: Runs
    observes_task: bool | None
    evaluation: str | None


@rule("arrays")
def foreign_policy(file: ArrayFile) -> Iterator[Finding]:
    """A policy belongs to a run and a stage of the group's logs."""
    match = POLICY.fullmatch(file.path.rsplit("/", 1)[-1])
    if f"/{POLICIES}/" not in file.path or match is None:
        return
    protocol, run, stage, _ = match.groups()
    runs = file.runs.get(protocol, ())
    if runs is not None and int(run) not in runs:
        hint = "Remove the policy, or add the run to the log."
        yield Finding(file.path, f"{protocol}.csv has no run {run}.", hint)
    if int(stage) not in stages(protocol, len(file.group.tasks)):
        yield Finding(file.path, f"{protocol}.csv has no stage {stage}.", "Remove the policy.")


@rule("policy")
def malformed_policy(file: PolicyFile) -> Iterator[Finding]:
    """A policy file has the arrays that the section Policies lists, of fitting shapes and finite values."""
    if file.arrays is None:
        yield Finding(file.path, "The file cannot be read.", WRITE)
        return
    for error in array_errors(file.arrays):
        yield Finding(file.path, error, WRITE)


@rule("policies")
def missing_policy(group: GroupPolicies) -> Iterator[Finding]:
    """A log has the policies of all its runs, stages and (in the single protocol) tasks, or none."""
    for protocol in PROTOCOLS:
        runs = group.runs.get(protocol)
        if runs is None or not any(name.startswith(f"{protocol}-") for name in group.names):
            continue
        for name in policy_names(protocol, runs, group.group):
            if name not in group.names:
                path = f"{group.group.name}/{POLICIES}/{name}"
                yield Finding(
                    path, f"{protocol}.csv has other policies, but not this one.", "Add the policy."
                )


@rule("policies")
def different_policies(group: GroupPolicies) -> Iterator[Finding]:
    """The policies of a group have the same numbers of observations and actions."""
    for what, attribute in (("observations", "num_inputs"), ("actions", "num_actions")):
        sizes = {path: getattr(summary, attribute) for path, summary in group.summaries.items()}
        first = next((size for size in sizes.values() if size is not None), None)
        for path, size in sizes.items():
            if size not in (None, first):
                message = f"The policy has {size} {what}; the first of the group has {first}."
                yield Finding(path, message, "Add the policies of this group.")


@rule("policies")
def policy_observes_task(group: GroupPolicies) -> Iterator[Finding]:
    """A policy has arrays per task only if [observes] task_in_evaluation is true, and at most one row per
    task of the group."""
    for path, summary in group.summaries.items():
        if summary.num_tasks and group.observes_task is False:
            hint = "Set [observes] task_in_evaluation = true, or use the same arrays for all tasks."
            yield Finding(path, "The policy depends on the task.", hint)
        elif summary.num_tasks > len(group.group.tasks):
            message = f"The policy has arrays for {summary.num_tasks} tasks of {len(group.group.tasks)}."
            yield Finding(path, message, "Store one row per task of the group.")


@rule("policies")
def sampled_policy(group: GroupPolicies) -> Iterator[Finding]:
    """If [protocol] evaluation is "deterministic", every policy is deterministic."""
    for path, summary in group.summaries.items():
        if group.evaluation == "deterministic" and summary.head != "deterministic":
            hint = 'Store the head that acts in evaluation, or set [protocol] evaluation = "sampled".'
            yield Finding(path, f"The head of the policy is {summary.head!r}.", hint)

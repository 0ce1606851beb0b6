"""Rules about the policies of the runs of a group. They are checked where policies are read, not to score."""

import functools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from gym_extensions.submissions.layout import CLONE
from gym_extensions.submissions.policies import files, mlp_arrays
from gym_extensions.submissions.problem import Finding, rule
from gym_extensions.submissions.rules.run_document import SubmittedRun


@dataclass(frozen=True)
class RunPolicies:
    """The arrays of a run's policies, and what the rules compare them with.

    Only the digest is compared if ``with_content`` is False. ``first`` is the first policy of the group that
    uses observations, None if there is none; ``earlier`` has the sketches of earlier runs of the protocol;
    ``observes_task`` and ``evaluation`` are those of the manifest, None if they are unknown.
    """

    run: SubmittedRun
    arrays: mlp_arrays.Arrays
    with_content: bool
    first: files.AnyPolicy | None
    earlier: Mapping[int, files.Sketches]
    observes_task: bool | None
    evaluation: str | None

    @functools.cached_property
    def errors(self) -> list[tuple[str, str]]:
        """What is wrong with the arrays, with the suffixes of the files."""
        found = files.run_errors(self.arrays, self.run.group, self.run.protocol)
        return list(found) if self.with_content else []

    @functools.cached_property
    def policies(self) -> dict[files.Key, files.AnyPolicy]:
        """The policies; none unless all arrays are valid."""
        if self.errors or not self.with_content:
            return {}
        return files.policies_of(self.arrays, self.run.group, self.run.protocol)

    @functools.cached_property
    def sketches(self) -> files.Sketches:
        """Sketches of the weights of the policies."""
        return files.parameter_sketch(self.policies)

    def where(self, key: files.Key) -> str:
        """The location of a policy."""
        return f"{self.run.file('')}, {files.policy_name(key)}"


@rule("policies")
def malformed_policy(stored: RunPolicies) -> Iterator[Finding]:
    """The policies of a run are those of every stage of its protocol (and of every task in the single
    protocol), with the arrays that docs/rollout-log.md lists, of fitting shapes and finite values, or ONNX
    networks as docs/policies.md describes them: standard operators, fixed shapes, no data elsewhere.
    (The gate and `verify` check this.)"""
    hint = "See docs/rollout-log.md; for a network, docs/policies.md."
    for suffix, error in stored.errors:
        yield Finding(stored.run.file(suffix), error, hint)


@rule("policies")
def exchanged_policies(stored: RunPolicies) -> Iterator[Finding]:
    """The document of a run states the digest of the arrays of its policies. (The gate and `verify` compare
    all; `score` compares those that are ONNX networks, and unpacks no .npz file.)"""
    stated, actual = stored.run.document.policies, files.content_sha256(stored.arrays)
    if stated is not None and stated.sha256 != actual:
        message = f"The policies have the digest {actual}; the document states {stated.sha256}."
        hint = f"Restore the files of the run, which are written together. {CLONE}"
        yield Finding(stored.run.key("policies"), message, hint)


@rule("policies")
def policies_of_another_group(stored: RunPolicies) -> Iterator[Finding]:
    """The policies of a group have the same numbers of observations and actions. (The gate and `verify`
    check this.)"""
    first = stored.first or next(iter(stored.policies.values()), None)
    if first is None:
        return
    for key, policy in stored.policies.items():
        sizes = (policy.num_inputs or first.num_inputs, policy.num_actions)
        expected = (first.num_inputs, first.num_actions)
        if sizes != expected:
            message = f"The policy has {sizes[0]} observations and {sizes[1]} actions; the first has "
            hint = "Add the policies of this group."
            yield Finding(stored.where(key), f"{message}{expected[0]} and {expected[1]}.", hint)


@rule("policies")
def policy_observes_task(stored: RunPolicies) -> Iterator[Finding]:
    """A policy has arrays per task, or reads the task, only if [observes] task_in_evaluation is true, and at
    most one row per task of the group. (The gate and `verify` check this.)"""
    for key, policy in stored.policies.items():
        if policy.num_tasks and stored.observes_task is False:
            hint = "Set [observes] task_in_evaluation = true, or use the same arrays for all tasks."
            yield Finding(stored.where(key), "The policy depends on the task.", hint)
        elif policy.num_tasks > len(stored.run.group.tasks):
            message = f"The policy has arrays for {policy.num_tasks} tasks of {len(stored.run.group.tasks)}."
            yield Finding(stored.where(key), message, "Store one row per task of the group.")


@rule("policies")
def sampled_policy(stored: RunPolicies) -> Iterator[Finding]:
    """If [protocol] evaluation is "deterministic", every policy is deterministic. (The gate and `verify`
    check this.)"""
    for key, policy in stored.policies.items():
        if stored.evaluation == "deterministic" and policy.head != "deterministic":
            hint = 'Store the head that acts in evaluation, or set [protocol] evaluation = "sampled".'
            yield Finding(stored.where(key), f"The head of the policy is {policy.head!r}.", hint)


@rule("policies")
def nearly_equal_policies(stored: RunPolicies) -> Iterator[Finding]:
    """No trained policies of two runs are nearly equal: the weights of a stage correlate by at most .99. Such
    runs are one run. (Runs that learn nothing, whose weights are those of stage 0 at every stage, may be
    equal. The gate and `verify` check this.)"""
    for number, sketches in stored.earlier.items():
        if where := files.nearly_equal(stored.sketches, sketches):
            message = f"Run {number} has nearly the same policy at {where}."
            yield Finding(stored.run.file(""), message, "Train each run with its own seed.")

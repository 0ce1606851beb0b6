"""Rules about the documents of runs: versions, fingerprints, curves, and the files that belong to them."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

import msgspec

from gym_extensions.catalog import fingerprints, groups, tasks
from gym_extensions.catalog.protocol import EVALUATION_EPISODES, IN_ORDER, Budget, stages, task_order
from gym_extensions.errors import did_you_mean
from gym_extensions.submissions import layout
from gym_extensions.submissions.characters import first_invisible
from gym_extensions.submissions.policies.files import missing_networks
from gym_extensions.submissions.problem import MAX_QUOTE, Finding, quote, rule
from gym_extensions.submissions.rules.manifest import strings
from gym_extensions.submissions.run import (
    Curve,
    InterimEvaluation,
    RunDocument,
    Versions,
    order_error,
    stage_steps,
)

BUDGET_TOLERANCE = 1.02
"""A run may exceed the budget by 2 %, for an agent whose last batch exceeds it."""
MAX_POINTER = 200
"""Bytes of a pointer of Git LFS at most; no .npz file of policies is so small."""


@dataclass(frozen=True)
class SubmittedRun:
    """A run: where its files are, its document, and what the rules compare it with.

    ``log_sha256`` is that of the log (empty without one), ``policies`` has the sizes of its files of policies
    by suffix, ``budget`` is None if the manifest names none, ``fingerprints`` those of the first run of the
    group.
    """

    group: groups.TaskGroup
    protocol: str
    run: int
    document: RunDocument
    log_sha256: str
    policies: Mapping[str, int]
    budget: Budget | None
    fingerprints: dict[str, str]

    def file(self, suffix: str = layout.DOCUMENT) -> str:
        """The path of a file of the run."""
        return layout.run_file(self.group.name, self.protocol, self.run, suffix)

    def key(self, name: str) -> str:
        """The location of a key of the document."""
        return f"{self.file()}, {name}"

    def part(self, name: str, part: Curve | InterimEvaluation) -> str:
        """The location of a curve or an evaluation in the document."""
        return self.key(f"{name} of stage {part.stage}, {part.task[:MAX_QUOTE]}")

    def parts(self) -> Iterator[tuple[str, Curve | InterimEvaluation]]:
        """All curves and evaluations, with the name of their key."""
        yield from (("curves", part) for part in self.document.curves)
        yield from (("evaluations", part) for part in self.document.evaluations)


@rule("document")
def misplaced_document(run: SubmittedRun) -> Iterator[Finding]:
    """The document of a run names the group (with its version), the protocol and the run of its path."""
    expected = {"group": run.group.id, "protocol": run.protocol, "run": run.run}
    for name, value in expected.items():
        actual = getattr(run.document, name)
        if actual != value:
            message = f"The value is {quote(actual)}; the file is that of {value!r}."
            yield Finding(run.key(name), message, "Move the files of the run to where they belong.")


@rule("document")
def wrong_order(run: SubmittedRun) -> Iterator[Finding]:
    """The document of a balanced run states the row of its number as the order of the tasks, that of a
    descending run the reversed order. The document of another run states none."""
    if message := order_error(run.document, run.group, run.protocol, run.run):
        hint = "Move the files of the run to where they belong, or train it as that run."
        yield Finding(run.key("order"), message, hint)


@rule("document")
def different_log(run: SubmittedRun) -> Iterator[Finding]:
    """The document states the SHA-256 of the run's log."""
    if run.log_sha256 and run.document.log != run.log_sha256:
        message = f"The log has the SHA-256 {run.log_sha256}; the document states {run.document.log}."
        hint = f"Restore the log; it is written together with its document. {layout.CLONE}"
        yield Finding(run.file(layout.LOG), message, hint)


@rule("document")
def different_policies(run: SubmittedRun) -> Iterator[Finding]:
    """A run has the policies that its document names: beside it, without an .npz file as one ONNX network
    each, or elsewhere if the document has their url. A run without policies is allowed; its log stays
    claimed."""
    policies, files = run.document.policies, run.policies
    if policies is None or policies.url:
        if files:
            message = "The document names no policies in the submission, but they are there."
            hint = "Write their digest in the document, or remove them."
            yield Finding(run.file(min(files)), message, hint)
        return
    hint = "Restore it, or write null in the key policies: then the log can only be claimed."
    if not files:
        message = f"There is neither {run.file(layout.POLICIES)} nor one .onnx file per stage."
        yield Finding(run.key("policies"), message, hint)
        return
    for suffix in missing_networks(files, run.group, run.protocol):
        yield Finding(run.file(suffix), "The file is missing, but the document names policies.", hint)
    if files.get(layout.POLICIES, MAX_POINTER + 1) <= MAX_POINTER:
        message = f"The file has {files[layout.POLICIES]} bytes; the document states {policies.size}."
        yield Finding(run.file(layout.POLICIES), message, f"Restore the file. {layout.CLONE}")


@rule("document")
def foreign_version(run: SubmittedRun) -> Iterator[Finding]:
    """The versions of gymnasium and mujoco are those of the published tasks."""
    for name, expected in fingerprints.table()["engine"].items():
        version = getattr(run.document.versions, name)
        if version != expected:
            message = f"The version is {quote(version)}; the published tasks have {expected!r}."
            yield Finding(run.key(f"versions.{name}"), message, f"Record the run with {name} {expected}.")


@rule("document")
def repeated_package(run: SubmittedRun) -> Iterator[Finding]:
    """No package of the key versions is repeated in the key packages."""
    for name in run.document.packages:
        if name in Versions.__struct_fields__:
            yield Finding(run.key("packages"), f"{quote(name)} is a key of versions.", "Remove it.")


@rule("document")
def control_character_in_document(run: SubmittedRun) -> Iterator[Finding]:
    """The strings of a document contain no control, invisible or bidirectional-override characters."""
    content = msgspec.to_builtins(run.document)
    for name in ("curves", "evaluations"):
        del content[name]  # foreign_curve checks their tasks
    for where, text, _ in strings(content, run.file()):
        if first_invisible(text):
            yield Finding(where, "The text contains a control or invisible character.", "Remove it.")


@rule("document")
def foreign_fingerprint(run: SubmittedRun) -> Iterator[Finding]:
    """The document has the published fingerprint of every task of the group, and no other. (The tasks of a
    custom group have the same fingerprints in all runs.)"""
    stated = run.document.fingerprints
    hint = "Evaluate in this benchmark's environments, with the pinned versions."
    for name in (name for name in stated if name not in run.group.task_ids):
        closest = did_you_mean(name[:MAX_QUOTE], run.group.task_ids)
        yield Finding(run.key("fingerprints"), f"{quote(name)} is not a task of {run.group.id}.", closest)
    for task in run.group.tasks:
        is_published = tasks.TASKS.get(task.id) == task
        expected = fingerprints.published(task.id) if is_published else run.fingerprints.get(task.id)
        actual = stated.get(task.id)
        if actual is None:
            yield Finding(run.key("fingerprints"), f"The fingerprint of {task.id} is missing.", hint)
        elif expected is not None and actual != expected:
            message = f"The fingerprint of {task.id} is {quote(actual)}; expected {expected!r}."
            yield Finding(run.key("fingerprints"), message, hint)


@rule("document")
def over_budget(run: SubmittedRun) -> Iterator[Finding]:
    """No run and no curve exceeds the budget's training steps by more than 2 % (the tolerance is for the last
    batch)."""
    if run.budget is None:
        return
    steps = stage_steps(run.budget, run.group, run.protocol)
    total = run.budget.steps_for(run.group.name) * len(run.group.tasks)
    hint = "Train within the budget, or name the larger budget in submission.toml."
    if run.document.steps > BUDGET_TOLERANCE * total:
        message = f"The run has {run.document.steps} steps; the budget {run.budget.name!r} has {total}."
        yield Finding(run.key("steps"), message, hint)
    for curve in run.document.curves:
        last = max(curve.steps, default=0)
        if last > BUDGET_TOLERANCE * steps:
            message = f"Step {last} exceeds the budget {run.budget.name!r} of {steps} steps."
            yield Finding(run.part("curves", curve), message, hint)


@rule("document")
def foreign_curve(run: SubmittedRun) -> Iterator[Finding]:
    """Every curve and every evaluation during training belongs to a task of the group and to a stage with
    training; where tasks are learned one after another, a stage trains one task. No curve is repeated."""
    group, protocol = run.group, run.protocol
    trained = [group.task_ids[index] for index in task_order(protocol, run.run, len(group.tasks))]
    allowed = [stage for stage in stages(protocol, len(group.tasks)) if stage > 0]
    seen = set[tuple[str, int, str]]()
    for name, part in run.parts():
        key, message = (name, part.stage, part.task), ""
        if part.task not in group.task_ids:
            message = f"{quote(part.task)} is not a task of {group.id}."
        elif part.stage not in allowed:
            message = f"Stage {part.stage} of the protocol {protocol} has no training."
        elif key in seen:
            message = "The stage and task have two of them."
        elif name == "curves" and protocol in IN_ORDER and part.task != trained[part.stage - 1]:
            message = f"Stage {part.stage} trains {trained[part.stage - 1]}."
        elif name == "curves" and protocol == "cumulative" and part.task != group.task_ids[-1]:
            message = f"The cumulative protocol trains {group.task_ids[-1]} alone."
        seen.add(key)
        if message:
            hint = "Include only curves of this run, one per stage and task."
            yield Finding(run.part(name, part), message, hint)


@rule("document")
def curve_order(run: SubmittedRun) -> Iterator[Finding]:
    """The steps of a curve, and of evaluations during training, increase from point to point, from 1 on."""
    for name, part in run.parts():
        if any(later <= step for step, later in pairwise([0, *part.steps])):
            hint = "Sort by step; every stage counts its steps from 0."
            yield Finding(run.part(name, part), "The steps do not increase from 1 on.", hint)


@rule("document")
def impossible_curve_return(run: SubmittedRun) -> Iterator[Finding]:
    """A return of a curve or an evaluation is within the bounds of the task's episode return
    (catalog/bodies)."""
    bounds = {task.id: task.return_bounds for task in run.group.tasks}
    for name, part in run.parts():
        low, high = bounds.get(part.task, (-float("inf"), float("inf")))
        wrong = next((value for value in part.returns if not low <= value <= high), None)
        if wrong is not None:
            limits = f"{low:g} to {high:g}"
            message = f"The return {wrong!r} is impossible; an episode of this task returns {limits}."
            hint = "Write means of the undiscounted, unscaled returns of episodes that ended."
            yield Finding(run.part(name, part), message, hint)


@rule("document")
def impossible_evaluation(run: SubmittedRun) -> Iterator[Finding]:
    """An evaluation during training has 1 to 20 episodes, those with a prescribed seed, and its step is less
    than the steps of its stage."""
    limit = stage_steps(run.budget, run.group, run.protocol) if run.budget else None
    for part in run.document.evaluations:
        where = run.part("evaluations", part)
        if not 1 <= part.episodes <= EVALUATION_EPISODES:
            hint = f"Write the number of episodes, 1 to {EVALUATION_EPISODES}."
            yield Finding(where, f"There are {part.episodes} episodes.", hint)
        if limit is not None and max(part.steps, default=0) >= limit:
            hint = "Count steps from the beginning of the stage; the log has the evaluation at its end."
            yield Finding(where, f"Step {max(part.steps)} is not before the end of the stage.", hint)

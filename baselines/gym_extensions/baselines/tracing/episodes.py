"""Repeats the evaluation of a stored policy, which gives the traces of its episodes once more."""

from __future__ import annotations

from pathlib import Path

from gym_extensions.baselines.agent import Card, Observes
from gym_extensions.baselines.recording.policy_agent import PolicyAgent
from gym_extensions.baselines.training.evaluator import Evaluator
from gym_extensions.baselines.training.jobs import Settings, TrainingJob
from gym_extensions.baselines.training.progress import traces_folder
from gym_extensions.baselines.training.seeding import training_seed
from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.task import Task
from gym_extensions.rollouts.layout import POLICIES, policy_name
from gym_extensions.rollouts.manifest import Manifest
from gym_extensions.rollouts.policies import Policy


class StoredPolicies:
    """The policies of a submission, evaluated as :func:`gym_extensions.baselines.record` evaluates them.

    On the machine of the log, a deterministic policy gives the logged episodes bit for bit; so does a sampled
    one that ``record`` has evaluated.

    Args:
        folder: the submission's folder.
        manifest: its manifest.
        scratch: an empty folder for the traces.
    """

    def __init__(self, folder: Path, manifest: Manifest, scratch: Path) -> None:
        self._folder, self._scratch = folder, scratch
        protocol, observes = manifest.protocol, manifest.observes
        self._card = Card(protocol.algorithm, evaluation=protocol.evaluation)
        self._settings = Settings(
            *(protocol.algorithm, protocol.budget, None),
            Observes(observes.task_in_training, observes.task_in_evaluation, observes.boundaries),
        )

    def traces(self, group: TaskGroup, protocol: str, run: int, stage: int, task: Task) -> Path | None:
        """The folder with the traces of all episodes of a cell; None if the submission lacks its policy."""
        path = self._folder / group.name / POLICIES / policy_name(protocol, run, stage, task.name)
        if not path.exists():
            return None
        index = group.tasks.index(task) if protocol == "single" else None
        agent = PolicyAgent(Policy.from_bytes(path.read_bytes()), self._card)
        agent.begin(training_seed(run, group.id, f"policy {stage}", task.id))
        evaluator = Evaluator(TrainingJob(group, protocol, run, index), self._settings, self._scratch)
        try:
            evaluator.evaluate(agent, stage, task, None)
        finally:
            evaluator.close()
        return traces_folder(self._scratch, group.name)

"""The policies of a job: checked against the agent's actions, and stored after every stage."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from gym_extensions.atomic import write_bytes
from gym_extensions.baselines.agent import Agent, Array, VectorEnv
from gym_extensions.baselines.training.jobs import TrainingJob
from gym_extensions.errors import BenchError
from gym_extensions.rollouts.layout import MAX_POLICY_BYTES, POLICIES, PROGRESS, policy_name
from gym_extensions.rollouts.policies import Policy
from gym_extensions.rollouts.policies.agreement import TOLERANCE, differences


def policies_folder(out: Path, group_name: str) -> Path:
    """The folder with the policies of unfinished runs."""
    return out / PROGRESS / group_name / POLICIES


def policy_of(agent: Agent) -> Policy | None:
    """The agent's policy; None if it has no method ``policy`` or cannot express its policy.

    An attribute ``policy`` that is not a method, such as a torch module, is something else.

    Raises:
        BenchError: the method returns neither a policy nor None.
    """
    method = getattr(agent, "policy", None)
    if not inspect.isroutine(method):
        return None
    policy: object = method()
    if policy is None or isinstance(policy, Policy):
        return policy
    message = f"Expected a Policy or None, got a value of type {type(policy).__name__}."
    raise BenchError("bad-policy", message, "policy()", "Return a gym_extensions.rollouts.policies.Policy.")


def require_agreement(
    policy: Policy, env: VectorEnv, seeds: Sequence[int], actions: Sequence[Array], task: int
) -> None:
    """Checks that the policy takes the first actions of evaluation episodes.

    Args:
        policy: the agent's policy.
        env: the evaluation environments of a task; they are reset.
        seeds: the reset seed of each environment.
        actions: the first action of each episode, as applied.
        task: index of the task in the group.

    Raises:
        BenchError: an action differs, or the observations have another size than the policy's inputs.
    """
    observations, _ = env.reset(seed=list(seeds))  # type: ignore[arg-type]
    space = env.single_action_space
    box = (space.low, space.high)  # type: ignore[attr-defined]
    difference = float(differences(policy, observations, np.stack(actions), box, task).max())
    if not difference <= TOLERANCE:
        message = f"The policy's actions differ from those of act() by {difference:.3g} half widths."
        hint = "Return the policy that act() uses, or None if it cannot be expressed as plain arrays."
        raise BenchError("policy-differs", message, "policy()", hint)


def store_policy(out: Path, job: TrainingJob, stage: int, policy: Policy | None) -> None:
    """Writes the policy after a stage, and removes that of an earlier attempt if there is none.

    A policy whose file would be too large for a submission is left out.
    """
    task_name = "" if job.task is None else job.group.tasks[job.task].name
    name = policy_name(job.protocol, job.run, stage, task_name)
    path = policies_folder(out, job.group.name) / name
    data = b"" if policy is None else policy.to_bytes()
    if 0 < len(data) <= MAX_POLICY_BYTES:
        write_bytes(path, data)
    else:
        path.unlink(missing_ok=True)

"""The experts: for a MuJoCo task one frozen policy as plain arrays, and a card of its origin.

Example:
    >>> from gym_extensions.references import experts
    >>> policy = experts.load("HopperGravityHalf")
    >>> policy.num_inputs
    11
"""

import functools
import hashlib
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Literal, NamedTuple

import msgspec

from gym_extensions.catalog import fingerprints
from gym_extensions.catalog.tasks import Task, task as published_task
from gym_extensions.errors import BenchError, did_you_mean
from gym_extensions.submissions.layout import MEBIBYTE, read_regular
from gym_extensions.submissions.policies import files, mlp, mlp_arrays

__all__ = ["ExpertCard", "card", "load", "names"]

DATA = Path(__file__).parent / "expert_policies"
"""Holds ``<task>.npz``, the policy, and ``<task>.json``, its card."""
EPISODES = 1000
"""Episodes of a complete measurement. A quick check uses the first 100."""
MAX_POLICY, MAX_CARD = 4 * MEBIBYTE, MEBIBYTE // 16
"""Largest files, in bytes."""
STANDARD_ERRORS, FLOOR_DEVIATIONS = 5.0, 2.0
"""How far the expert's mean must lie above the floor: in standard errors of its mean, and in standard
deviations of the floor agent's episodes."""

Purpose = Literal["select", "compare", "measure", "train", "challenge"]
PURPOSES: tuple[Purpose, ...] = ("select", "compare", "measure", "train")
"""The purposes below 2³¹; the seeds of challenges lie above."""


def seed(task: str | Task, purpose: Purpose, index: int) -> int:
    """The reset seed of episode ``index``, from 0, in [0, 2³¹), and of a challenge in [2³¹, 2³²).

    Four times a digest of task and index, plus the number of the purpose. So the episodes that train a
    policy, select it among candidates, compare it with another policy and measure it never share a seed. The
    seed of a challenge is 2³¹ plus half of the digest.
    """
    digest = hashlib.sha256(f"expert/{_row(task).id}/{index}".encode()).digest()
    value = int.from_bytes(digest[:4], "little")
    return 2**31 + (value >> 1) if purpose == "challenge" else 4 * (value >> 3) + PURPOSES.index(purpose)


class Step(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """One training run on the way to a policy, or the stored policy that the way starts from.

    Args:
        name: of the recipe, or ``stored:<entry>/<group>/<file>`` for a policy of a submission.
        agent: trpo, sac, or the name of the submission.
        steps: environment steps until the checkpoint that was taken.
        cpu_seconds: of training until then; None where it was not recorded.
        command: repeats the run.
        tasks: what it was trained on.
    """

    name: str
    agent: str
    steps: int | None = None
    cpu_seconds: float | None = None
    command: str = ""
    tasks: tuple[str, ...] = ()


class Measurement(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Mean and standard deviation of the returns of the first ``episodes`` seeds of a purpose.

    ``success`` is the share of episodes that the task counts as a success; None where it defines none.
    """

    episodes: int
    mean: float
    deviation: float
    success: float | None = None
    cpu_seconds: float | None = None

    @property
    def standard_error(self) -> float:
        """Of the mean."""
        return self.deviation / math.sqrt(self.episodes)


class ExpertCard(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """How an expert came about, and what it is worth.

    Attributes:
        task, fingerprint: the id of its task, and of the task's definition.
        policy: its :func:`digest`.
        history: the training runs, the first one first.
        measurement: of its returns on the measurement seeds.
        from_submission: whether the policy or an ancestor of it is a policy of a submission.
        candidates: policies that were compared on the selection seeds, this one included.
        steps_tried: environment steps of all training runs with candidates for this task.
        selection: of this policy on the selection seeds.
        first_hundred: mean return of the first 100 measurement seeds, for a quick check.
        provisional: why the expert does not do what the task is for; empty if it does.
    """

    task: str
    fingerprint: str
    policy: str
    history: tuple[Step, ...]
    measurement: Measurement
    from_submission: bool
    candidates: int
    steps_tried: int
    selection: Measurement
    first_hundred: float
    provisional: str = ""


STORED = re.compile(r"stored:([^/]+)/([^/]+)/([a-z]+)-run(\d+)-stage(\d+)(?:-(.+))?")
"""The name of a step that is a policy of a submission: submission, group, protocol, run, stage and, in the
single protocol, task."""


class Origin(NamedTuple):
    """A policy of a submission that is the expert of a task, or an ancestor of it."""

    task: str
    run: int
    stage: int
    is_expert: bool


@functools.cache
def origins() -> Mapping[tuple[str, str, str], tuple[Origin, ...]]:
    """The policies of submissions behind the experts, by submission, name of the group and protocol."""
    found: dict[tuple[str, str, str], tuple[Origin, ...]] = {}
    for name in names():
        steps = card(name).history
        for step in steps:
            if match := STORED.fullmatch(step.name):
                submission, group, protocol, run, stage, _ = match.groups()
                origin = Origin(name, int(run), int(stage), step is steps[-1])
                found[submission, group, protocol] = (*found.get((submission, group, protocol), ()), origin)
    return found


def floor_margin(standard_error: float, floor_deviation: float) -> float:
    """How far above the floor the mean return of an anchor with this standard error must lie."""
    return max(STANDARD_ERRORS * standard_error, FLOOR_DEVIATIONS * floor_deviation)


def names(folder: Path = DATA) -> list[str]:
    """The bare names of the tasks with an expert, in alphabetical order."""
    return sorted(path.stem for path in folder.glob("*.json"))


def load(task: str | Task, folder: Path = DATA) -> mlp.Policy:
    """The expert of a task (or its id or bare name); ``act(observations)`` gives its actions.

    Raises:
        BenchError: there is no such task, the task has no expert, the file is not the one that the card
            describes, or it is not a policy.
    """
    path = folder / f"{_row(task).bare_name}.npz"
    described, policy = card(task, folder), read_policy(path)
    if digest(policy) != described.policy:
        raise BenchError("other-policy", "The file is not the policy of its card.", str(path))
    return policy


def card(task: str | Task, folder: Path = DATA) -> ExpertCard:
    """The card of a task's expert. Raises ``BenchError`` as :func:`load` does."""
    row = _row(task)
    path = folder / f"{row.bare_name}.json"
    if not path.exists():
        hint = did_you_mean(path.stem, names(folder))
        raise BenchError("no-expert", f"{path.stem} has no expert.", str(folder), hint)
    try:
        found = msgspec.json.decode(read_regular(path, MAX_CARD), type=ExpertCard)
    except (OSError, ValueError, RecursionError) as error:
        raise BenchError("bad-card", f"The card cannot be read: {error}.", str(path)) from error
    if row.id != found.task:
        raise BenchError("bad-card", f"The card is not one of {row.name}.", str(path))
    if found.fingerprint != fingerprints.published(row.id):
        message = f"The policy was measured on another definition of {row.name}: {found.fingerprint}."
        raise BenchError("foreign-fingerprint", message, str(path), "Measure it again, or remove it.")
    return found


def digest(policy: mlp.Policy) -> str:
    """SHA-256 of a policy's arrays: name, type, shape and values of each, in the order of their names."""
    return files.content_sha256(policy.arrays())


def read_policy(path: Path) -> mlp.Policy:
    """The policy of an npz file. Raises ``BenchError`` if it cannot be read or is not a policy."""
    try:
        arrays = files.npz_arrays(read_regular(path, MAX_POLICY), str(path))
    except OSError as error:
        raise BenchError("bad-policy", f"The file cannot be read: {error}.", str(path)) from error
    if wrong := next(mlp_arrays.array_errors(arrays), ""):
        raise BenchError("bad-policy", wrong, str(path), mlp.HINT)
    return mlp.Policy.from_arrays(arrays)


def _row(task: str | Task) -> Task:
    return task if isinstance(task, Task) else published_task(task)

"""The document of a run (``run3.json``): how it was trained, its curves, and what belongs to it."""

import hashlib
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from gym_extensions.catalog.groups import TaskGroup
from gym_extensions.catalog.protocol import Budget, task_order
from gym_extensions.errors import BenchError
from gym_extensions.files import write_text
from gym_extensions.submissions.layout import DOCUMENT, max_bytes, read_regular

ARITHMETIC: Literal[2] = 2
"""How plain policies compute: docs/rollout-log.md#arithmetic. The first was that of a machine's numpy, and is
repeated by the same kind of machine."""

LONGEST = 200
"""Most characters of a name or version."""
Text = Annotated[str, Meta(max_length=LONGEST)]
Count = Annotated[int, Meta(ge=0, le=2**53 - 1)]
Date = Annotated[str, Meta(pattern=r"^\d{4}-(0[1-9]|1[0-2])-(0[1-9]|[12]\d|3[01])$")]
Sha256 = Annotated[str, Meta(pattern="^[0-9a-f]{64}$")]
Measure = Annotated[float, Meta(ge=0)]


class Versions(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Versions of the packages, the platform and the BLAS kernels that the run used."""

    gym_extensions: Text
    gymnasium: Text
    mujoco: Text
    numpy: Text
    python: Text
    platform: Text
    blas: Text = ""


class Machine(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The computer that trained the run, or only evaluated its policies (``record``)."""

    processor: Text
    cores: Annotated[int, Meta(ge=1)]


class Memory(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Most transitions stored at once, and the agent's parameters at the start and end of training."""

    stored_steps: Count
    parameters_first: Count
    parameters_last: Count


class Curve(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The training curve of a task: the mean return of the training episodes that ended since the last point.

    ``steps`` count training steps within the stage (sequential), the task (single) or the run (joint, where
    every task of the group has a curve of stage 1).
    """

    stage: Count
    task: Text
    steps: list[Count]
    returns: list[float]


class InterimEvaluation(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Evaluations of a task while a stage goes on.

    ``steps`` count training steps since the stage began, ``returns`` are means over ``episodes`` episodes
    from the first of the task's prescribed seeds.
    """

    stage: Count
    task: Text
    episodes: Count
    steps: list[Count]
    returns: list[float]


class PolicyFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The policies of the run: the digest of their arrays, the bytes of the file, and where it lies.

    ``sha256`` is that of the content (:func:`gym_extensions.submissions.policies.files.content_sha256`).
    ``url`` is empty if the files lie beside the document; ``size`` is their sum.
    """

    sha256: Sha256
    size: Count
    url: Annotated[str, Meta(max_length=500)] = ""


class RunDocument(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How a run was trained, and what belongs to it. docs/rollout-log.md describes the keys."""

    format: Literal[1] = 1
    group: Text  # its id, with its version
    protocol: Literal["sequential", "single", "joint", "cumulative", "descending", "balanced"]
    run: Count  # the training seed
    order: list[Text] = []  # the task ids in the order of training, where it is not that of the group
    command: Annotated[str, Meta(max_length=4000)] = ""  # what trained it; empty if it is not known
    commit: Text = ""  # of the code; empty if it is not known
    by: Text = ""  # who trained it, if not the authors of the submission: a donated run
    date: Date | None = None  # the day on which the training ended
    versions: Versions
    packages: dict[Text, Text] = {}  # versions of those that the agent uses besides the ones of ``versions``
    machine: Machine | None = None
    steps: Count  # training steps over all stages
    steps_counted: bool = True  # by the training loop; False for policies that ``record`` evaluated
    cpu_seconds: Measure | None = None  # of the training and evaluation, an agent's in a box included
    peak_memory_mb: Measure | None = None  # of the process; that of an agent in a box is added
    memory: Memory
    fingerprints: dict[Text, Text]  # of every task of the group, by task id
    curves: list[Curve] = []  # by stage and task in training order
    evaluations: list[InterimEvaluation] = []  # in the same order
    arithmetic: Literal[1, 2] = 1  # of plain deterministic policies in the log (``ARITHMETIC``)
    log: Sha256  # of the run's log
    policies: PolicyFile | None = None  # None if the run publishes none; then it cannot be verified

    @property
    def digest(self) -> str:
        """The SHA-256 of the document: what a verification is about, with the log and the policies.

        Of the policies their digest counts, not where they lie.
        """
        policies = self.policies.sha256 if self.policies else None
        return content_digest({**stated(self), "policies": policies})

    @property
    def files(self) -> str:
        """The SHA-256 of the digests of log and policies: what new seeds and a refusal are about."""
        return content_digest([self.log, self.policies.sha256 if self.policies else None])


def stated(values: msgspec.Struct) -> dict[str, object]:
    """The keys of a document or section whose values are not the default ones, as in a file."""
    found = {}
    for field in msgspec.structs.fields(values):
        make, value = field.default_factory, getattr(values, field.name)
        if value != (field.default if make is msgspec.NODEFAULT else make()):
            found[field.name] = msgspec.to_builtins(value)
    return found


def content_digest(content: object) -> str:
    """The SHA-256 of builtin values as JSON without spaces, with sorted keys."""
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def order_of(group: TaskGroup, protocol: str, run: int) -> list[str]:
    """What the document of a run states as ``order``."""
    indices = task_order(protocol, run, len(group.tasks)) if protocol in ("descending", "balanced") else ()
    return [group.task_ids[index] for index in indices]


def order_error(document: RunDocument, group: TaskGroup, protocol: str, run: int) -> str:
    """What is wrong with the order that a document states, given the place of its file; empty if nothing."""
    expected = order_of(group, protocol, run)
    if document.order == expected:
        return ""
    stated, needed = (", ".join(ids)[:LONGEST] or "no order" for ids in (document.order, expected))
    return f"It states {stated}; the document of {protocol} run {run} states {needed}."


def stage_steps(budget: Budget, group: TaskGroup, protocol: str) -> int:
    """Training steps of a stage: of a task, or of all tasks together in ``joint`` and ``cumulative``."""
    return budget.steps_for(group.name) * (len(group.tasks) if protocol in ("joint", "cumulative") else 1)


def run_of(data: bytes) -> RunDocument:
    """The document in the content of a file. Raises ``ValueError`` with what is wrong and where."""
    document = msgspec.json.decode(data, type=RunDocument)
    parts: list[Curve | InterimEvaluation] = [*document.curves, *document.evaluations]
    for part in parts:
        if len(part.steps) != len(part.returns):
            counts = f"{len(part.steps)} steps and {len(part.returns)} returns"
            raise ValueError(f"A curve of stage {part.stage} has {counts}")
        if not all(map(math.isfinite, part.returns)):
            raise ValueError(f"A curve of stage {part.stage} has a return that is not finite")
    return document


def read_run(path: Path) -> RunDocument:
    """The document of a run. Raises ``BenchError`` if the file cannot be read or is not such a document."""
    try:
        return run_of(read_regular(path, max_bytes(DOCUMENT)))
    except (OSError, ValueError, RecursionError) as error:
        hint = "docs/rollout-log.md lists the keys; gym_extensions.submissions.run.write_run writes them."
        raise BenchError("bad-run", f"{error}.", str(path), hint) from error


def run_text(document: RunDocument) -> str:
    """The text of the document's file: a key per line, and a curve per line."""
    lines = []
    for key, value in msgspec.to_builtins(document).items():
        if key == "order" and not value:
            continue
        if isinstance(value, list) and value:
            parts = ",\n  ".join(json.dumps(part, allow_nan=False, ensure_ascii=False) for part in value)
            text = f"[\n  {parts}\n ]"
        else:
            text = json.dumps(value, allow_nan=False, ensure_ascii=False)
        lines.append(f' "{key}": {text}')
    return "{\n" + ",\n".join(lines) + "\n}\n"


def write_run(path: Path, document: RunDocument) -> None:
    """Writes the document of a run. Raises ``ValueError`` for a number that is not finite."""
    write_text(path, run_text(document))


def file_sha256(path: Path) -> str:
    """The SHA-256 of a file as hexadecimal digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def consecutive(runs: Sequence[int]) -> int:
    """The number N of runs 0 to N − 1 that are all there.

    >>> consecutive((0, 1, 2, 4))
    3
    """
    return next(number for number in range(len(runs) + 1) if number not in runs)

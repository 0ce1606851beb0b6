"""submission.toml: who submits, what was run, and how. Every key is declared here, once."""

import tomllib
from typing import Annotated, Any, Literal, get_args

import msgspec
from msgspec import Meta

from gym_extensions.catalog.protocol import BUDGETS
from gym_extensions.submissions.run import content_digest

FORMAT: Literal[1] = 1
SETTINGS = ("protocol", "observes", "tuning", "hyperparameters")
"""The sections that boards show or compare. The others are prose."""
SHORT, LONG = 100, 4000
"""Most characters of a string; most elements of a list is ``SHORT`` too."""
MAX_LINE = 20_000
"""Most characters of a line: ``tomllib`` needs time in proportion to the square of the parts of a dotted key
(https://github.com/python/cpython/issues/149231)."""

Scalar = str | int | float | bool
Hyperparameter = Scalar | tuple[Scalar, ...]
Evaluation = Literal["sampled", "deterministic"]
"""How an agent selects actions during evaluation."""

LABEL = "[A-Za-z0-9]([A-Za-z0-9-]*[A-Za-z0-9])?"
WEB = rf"^(https?://{LABEL}(\.{LABEL})*(:[0-9]{{1,5}})?(/[!#-&(-;=?-\[\]-~]*)?)?$(?!\n)"
"""The host has ASCII letters, digits, dots and dashes, so that none looks like another. The path has
printable ASCII characters except quotes, angle brackets and backslashes."""

Text = Annotated[str, Meta(max_length=SHORT, description=f"a string of at most {SHORT} characters")]
LongText = Annotated[str, Meta(max_length=LONG, description=f"a string of at most {LONG} characters")]
_URL = "a web address of at most 500 ASCII characters that starts with https:// or http://"
Url = Annotated[str, Meta(max_length=500, pattern=WEB, description=f"{_URL}, or an empty string")]
Count = Annotated[int, Meta(ge=0, le=2**53 - 1, description="an integer from 0 to 2⁵³ − 1")]
Flag = Annotated[bool, Meta(description="true or false")]
Name = Annotated[str, Meta(min_length=1, max_length=SHORT)]
Names = Annotated[
    tuple[Name, ...], Meta(max_length=SHORT, description=f"a list of strings of 1 to {SHORT} characters")
]


class Code(msgspec.Struct, frozen=True):
    """Address and commit of the agent's code, each of which may be empty."""

    url: Url = ""
    commit: Text = ""


class Protocol(msgspec.Struct, frozen=True):
    """The training budget, the algorithm, and how it selects actions in evaluation.

    ``parent`` is the algorithm that it equals until the end of the first stage; empty if it is its own.
    """

    budget: Literal[tuple(BUDGETS)]  # type: ignore[valid-type]
    algorithm: Text
    evaluation: Evaluation
    parent: Text = ""


class Observes(msgspec.Struct, frozen=True):
    """What the agent observes besides the task's observations: the task's identity, and task boundaries.

    It is the attribute ``observes`` of an agent. A manifest states every key.

    Attributes:
        task_in_training: the tasks that are trained, in ``learn``.
        task_in_evaluation: the task that is evaluated, in ``act``. Such submissions have separate boards.
        boundaries: the number of the stage and the number of tasks, in ``learn``. An agent whose
            ``learn`` works differently from its second call on, as with a penalty on forgetting, needs it.

    Example:
        >>> Observes(task_in_training=True, boundaries=True)
        Observes(task_in_training=True, task_in_evaluation=False, boundaries=True)
    """

    task_in_training: Flag = False
    task_in_evaluation: Flag = False
    boundaries: Flag = False


BOX_PACKAGES = ("numpy", "scipy", "gymnasium", "torch", "stable-baselines3", "onnx", "onnxruntime")
"""The packages that an agent in a box may import. Their names with ``_`` are those of their modules."""
Entry = Annotated[
    str,
    Meta(
        pattern=r"^[A-Za-z_][A-Za-z0-9_]*\.py:[A-Za-z_][A-Za-z0-9_]*$(?!\n)",
        max_length=SHORT,
        description="a file of agent/ and its factory, such as agent.py:make",
    ),
]


class AgentCode(msgspec.Struct, frozen=True):
    """Where the factory in ``agent/`` is, and the packages that it imports besides numpy."""

    entry: Entry
    packages: Names = ()


class Tuning(msgspec.Struct, frozen=True):
    """Training steps spent on choosing the settings, over all trials, and the tasks of these trials."""

    steps: Count
    tasks: Names


class Manifest(msgspec.Struct, frozen=True, kw_only=True):
    """A submission's manifest. ``reported`` names a published table that replaces logs.

    ``tuning`` is None only if ``reported`` is set. ``agent`` is None if the submission brings no code.
    """

    format: Literal[1] = FORMAT
    title: Text
    authors: Names
    description: LongText
    code: Code = Code()
    agent: AgentCode | None = None
    protocol: Protocol
    observes: Observes
    tuning: Tuning | None = None
    hyperparameters: dict[str, Hyperparameter] = {}
    reported: Text = ""

    @property
    def digest(self) -> str:
        """The SHA-256 of what boards show or compare (``SETTINGS``): a verification is about this, too."""
        return content_digest({name: msgspec.to_builtins(getattr(self, name)) for name in SETTINGS})


SECTIONS: dict[str, type[msgspec.Struct]] = {
    key.name: kind
    for key in msgspec.structs.fields(Manifest)
    for kind in (key.type, *get_args(key.type))
    if isinstance(kind, type) and issubclass(kind, msgspec.Struct)
}
"""The types of the sections with fixed keys, by name."""


def parse(data: bytes) -> dict[str, Any]:
    """The tables of submission.toml. Raises ``ValueError`` with what is wrong."""
    text = data.decode("utf-8-sig")
    for number, line in enumerate(text.split("\n"), 1):
        if len(line) > MAX_LINE:
            raise ValueError(f"Line {number} has more than {MAX_LINE} characters")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError("Tables and lists are nested too deeply") from None


def manifest_of(tables: dict[str, Any]) -> Manifest:
    """The manifest in tables without findings."""
    return msgspec.convert(tables, Manifest)

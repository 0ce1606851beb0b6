"""The record of a training here (``trained/2.toml``): what was trained, on which seeds, and what failed.

The base branch writes it. The runs lie in ``trained/2/``, laid out as a submission of their own, and belong
to the second version of ``agent/`` that was merged. Earlier versions keep theirs: attempts are counted.
"""

import hashlib
import tomllib
from collections.abc import Mapping
from typing import Annotated

import msgspec
import tomli_w
from msgspec import Meta

from gym_extensions.submissions.review import Date, RunKey, Sha256, Text


class Training(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A training of one version of an agent.

    Attributes:
        date: the day on which it began.
        version: of gym_extensions.
        commit: the one that merged this version of the code.
        value: public hexadecimal digits that were fixed after it; may be empty.
        agent: the digest of the code (:func:`code_digest`).
        runs: the digest of each run, by name.
        failed: why the agent failed in a run. The run that lies in its place is that of the agent ``zero``,
            which is the floor of every task of the core.
    """

    date: Date
    version: Text
    commit: Annotated[str, Meta(pattern="^[0-9a-f]{40,64}$")]
    value: Annotated[str, Meta(pattern="^([0-9a-f]{40,128})?$")] = ""
    agent: Sha256
    runs: dict[RunKey, Sha256] = {}
    failed: dict[RunKey, Text] = {}

    @property
    def seeds(self) -> str:
        """The text from which, with group and run, the training seeds follow. Nobody knew it before."""
        return f"{self.commit}/{self.value}/{self.agent}"


def code_digest(sources: Mapping[str, bytes], entry: str) -> str:
    """The SHA-256 of one line per file of agent/, sorted (path, space, SHA-256), and the entry.

    Another entry may be another agent. It is empty without any file.
    """
    lines = (f"{path} {hashlib.sha256(sources[path]).hexdigest()}\n" for path in sorted(sources))
    return hashlib.sha256("".join([*lines, entry]).encode()).hexdigest() if sources else ""


def training_of(data: bytes) -> Training:
    """The record in the content of its file. Raises ``ValueError`` with what is wrong."""
    return msgspec.convert(tomllib.loads(data.decode("utf-8")), Training)


def training_text(training: Training) -> str:
    """The text of a record. Equal records give equal texts."""
    return tomli_w.dumps(msgspec.to_builtins(training))

"""What the base branch writes: review.toml with verifications and decisions, and records of training here.

A record (``trained/2.toml``) says what was trained, on which seeds, and what failed. The runs lie in
``trained/2/``, laid out as a submission of their own, and belong to the second version of ``agent/`` that was
merged. Earlier versions keep theirs: attempts are counted.
"""

import hashlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Literal, get_args

import msgspec
import tomli_w
from msgspec import Meta

from gym_extensions.catalog.protocol import PROTOCOLS
from gym_extensions.errors import BenchError
from gym_extensions.files import write_text
from gym_extensions.submissions.layout import REVIEW, max_bytes, read_regular
from gym_extensions.submissions.run import Date, RunDocument, Sha256

Level = Literal["reported", "claimed", "verified", "trained here"]
LEVELS: tuple[Level, ...] = get_args(Level)
"""From a printed table to runs that the project trained itself."""
REPORTED, CLAIMED, VERIFIED, TRAINED_HERE = LEVELS
Action = Literal["accepted", "withdrawn", "challenged"]
NEW_SEEDS_ALPHA = 0.004
"""Probability of rejecting an honest submission by the test on new seeds."""
TOLERANCE = 1e-3
"""Relative difference of returns up to which an episode of an ONNX network counts as repeated."""

Text = Annotated[str, Meta(max_length=4000)]
Value = Annotated[str, Meta(pattern="^[0-9a-f]{8,128}$")]
RunKey = Annotated[str, Meta(pattern=rf"^[a-z0-9-]+/({'|'.join(PROTOCOLS)})/run(0|[1-9]\d{{0,8}})$")]
"""The name of a run: ``hopper-gravity/sequential/run3``."""
Count = Annotated[int, Meta(ge=0)]
Probability = Annotated[float, Meta(ge=0, le=1)]


class Verification(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a verification of some runs found. docs/rollout-log.md describes the keys."""

    date: Date
    version: Text  # of gym_extensions
    value: Value  # hexadecimal digits from which the new seeds follow; fixed after the runs
    settings: Sha256  # the digest of what the manifest says of the agent (``Manifest.digest``)
    runs: dict[RunKey, Sha256]  # the digest of each run: of its document, log and policies
    files: dict[RunKey, Sha256] = {}  # the same of its log and policies alone (``RunDocument.files``)
    episodes: Count = 0  # logged episodes that were tried to repeat
    repeated: Count = 0  # how many of them were repeated (``how_repeated``)
    difference: Text = ""  # where the first difference lies and how large it is
    runtime: Text = ""  # what ran ONNX networks, with its version; empty if all policies are plain arrays
    cells: Count  # cells of 20 episodes on new seeds
    p_value: Probability  # of the returns on new seeds
    second_p_value: Probability | None = None  # of a second draw, if the first was suspicious
    passed: bool  # whether the returns agree
    undecided: Text | None = None  # why nothing was found out, such as slow policies; then it did not pass
    retrained: list[RunKey] = []  # the runs that were trained again, and agree: they are *reproduced*


def how_repeated(runtime: str) -> str:
    """How closely episodes had to be repeated, in words. ``runtime`` is that of a verification."""
    return f"within {100 * TOLERANCE:g} % of the return, by {runtime}" if runtime else "bit for bit"


class Decision(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a maintainer decided about the submission."""

    action: Annotated[Action, Meta(description="`accepted`, `withdrawn` or `challenged`")]
    by: Annotated[Text, Meta(description="who decided")]
    date: Annotated[Date, Meta(description="YYYY-MM-DD")]
    reason: Annotated[Text, Meta(description="why")]


class Review(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Verifications and decisions, oldest first."""

    verifications: list[Verification] = []
    decisions: list[Decision] = []


def is_withdrawn(decisions: Iterable[Decision]) -> bool:
    """Whether the last acceptance or withdrawal is a withdrawal; such a submission is on no board."""
    standing = [part.action for part in decisions if part.action != "challenged"]
    return standing[-1:] == ["withdrawn"]


def review_of(data: bytes) -> Review:
    """The review in the content of review.toml. Raises ``ValueError`` with what is wrong."""
    return msgspec.toml.decode(data, type=Review)


def read_review(folder: Path) -> Review:
    """The review of a submission, empty if it has none. Raises ``BenchError`` if it cannot be read."""
    path = folder / REVIEW
    try:
        return review_of(read_regular(path, max_bytes(REVIEW)))
    except FileNotFoundError:
        return Review()
    except (OSError, ValueError, RecursionError) as error:
        hint = "gym-extensions verify and maintain decide write this file; restore it."
        raise BenchError("bad-review", f"{error}.", str(path), hint) from error


def review_text(review: Review) -> str:
    """The text of review.toml. Equal reviews give equal texts."""
    parts = []
    for name, values in msgspec.to_builtins(review).items():
        for value in values:
            tables = {key: content for key, content in value.items() if isinstance(content, dict)}
            stated = {key: value[key] for key in value if key not in tables and value[key] is not None}
            parts.append(f"[[{name}]]\n{tomli_w.dumps(stated)}")
            parts += [f"[{name}.{key}]\n{tomli_w.dumps(table)}" for key, table in tables.items() if table]
    return "\n".join(parts)


def write_review(folder: Path, review: Review) -> None:
    """Writes review.toml of a submission, whole or not at all."""
    write_text(folder / REVIEW, review_text(review))


def add_to_review(
    folder: Path, verifications: Iterable[Verification] = (), decisions: Iterable[Decision] = ()
) -> None:
    """Adds verifications and decisions to the review of a submission, all or none."""
    known = read_review(folder)
    review = Review(
        verifications=[*known.verifications, *verifications], decisions=[*known.decisions, *decisions]
    )
    write_review(folder, review)


def about(review: Review, settings: str, documents: Mapping[str, RunDocument]) -> Review:
    """The review as it is about runs with these documents, by name.

    A refusal is about their logs and policies, whatever else was edited after it. Other verifications are
    about the whole document and the settings.
    """

    def restated(part: Verification) -> Verification:
        refused = {} if part.passed or part.undecided else part.files
        now = {key: each.digest for key, each in documents.items() if refused.get(key) == each.files}
        return msgspec.structs.replace(part, settings=settings, runs=part.runs | now) if now else part

    return msgspec.structs.replace(review, verifications=[restated(each) for each in review.verifications])


def decided(review: Review, settings: str, digests: Mapping[str, str]) -> dict[str, list[Verification]]:
    """The verifications of each run, as it and the settings are now, without runs that have none."""
    found: dict[str, list[Verification]] = {}
    for key, digest in digests.items():
        current = (part for part in review.verifications if part.settings == settings)
        if parts := [part for part in current if part.runs.get(key) == digest]:
            found[key] = parts
    return found


def why_claimed(review: Review, settings: str, digests: Mapping[str, str]) -> str:
    """Why a log with runs of these digests is not verified, as a sentence; empty if it is."""
    now = decided(review, settings, digests)
    for key, digest in digests.items():
        if failed := [part for part in now.get(key, ()) if not part.passed and not part.undecided]:
            return f"The verification of {failed[0].date} did not pass."
        if key in now and not any(part.passed for part in now[key]):
            return f"The verification is {now[key][-1].undecided}."
        if key not in now:
            before = [part.runs[key] for part in review.verifications if key in part.runs]
            if digest in before:
                return "The settings in submission.toml changed after the verification."
            return f"{key} {'changed after its verification' if before else 'is not verified yet'}."
    return ""


def reproduced(review: Review, settings: str, digests: Mapping[str, str]) -> set[str]:
    """The runs, as they are now, that were trained again and agree."""
    found = decided(review, settings, digests).items()
    return {key for key, parts in found if any(part.passed and key in part.retrained for part in parts)}


def level(review: Review, settings: str, digests: Mapping[str, str]) -> Level:
    """The level of a log that was submitted: claimed or verified.

    It is verified if each of its runs, as it is now, is in a verification that passed and in none that
    failed.

    Args:
        review: the review of the submission.
        settings: the digest of the manifest's settings.
        digests: the digest of every run of the log, by the run's name
            (:meth:`gym_extensions.submissions.submission.SubmittedGroup.digests`).
    """
    return CLAIMED if not digests or why_claimed(review, settings, digests) else VERIFIED


def is_verified(level: Level | None) -> bool:
    """Whether a level is at least ``verified``, which a rank needs."""
    return level in (VERIFIED, TRAINED_HERE)


class Training(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A training of one version of an agent. docs/rollout-log.md describes the keys."""

    date: Date  # the day on which it began
    version: Text  # of gym_extensions
    commit: Annotated[str, Meta(pattern="^[0-9a-f]{40,64}$")]  # the one that merged this version of the code
    value: Annotated[str, Meta(pattern="^([0-9a-f]{40,128})?$")] = ""  # public digits, fixed after the commit
    agent: Sha256  # the digest of the code (``code_digest``)
    runs: dict[RunKey, Sha256] = {}  # the digest of each run
    failed: dict[RunKey, Text] = {}  # why; in the run's place lies that of the agent ``zero``, the floor

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
    return msgspec.toml.decode(data, type=Training)


def training_text(training: Training) -> str:
    """The text of a record. Equal records give equal texts."""
    return tomli_w.dumps(msgspec.to_builtins(training))

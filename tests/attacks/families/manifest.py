"""Attacks with statements of the manifest: names, settings, and what the agent observes."""

from __future__ import annotations

from pathlib import Path

from ..attack import NOT_DETECTED, REPRODUCED, Attack
from ..forger import Forger
from ..forgeries.runs import declared
from ..judge import Make, submission
from ..workshop import Workshop


def appended(text: str, before: str = "[code]") -> Make:
    """Adds lines to the manifest before a section."""

    def make(workshop: Workshop) -> Path:
        forger = Forger(workshop.copy("random"))
        path = forger.folder / "submission.toml"
        path.write_text(
            path.read_text().replace(before, f"{text}\n\n{before}"), encoding="utf-8", newline="\n"
        )
        return forger.folder

    return make


def stated(title: str, key: str, value: str, stop: str) -> Attack:
    """An attack that states a value that a rule refuses."""
    return Attack(title, submission(declared(key, value, base="random")), stop, quick=True)


def believed(title: str, key: str, value: str, needed: str) -> Attack:
    """An attack with a statement that nothing contradicts."""
    make = declared(key, value, base="random")
    return Attack(title, submission(make), NOT_DETECTED, REPRODUCED, REPRODUCED, needed)


def readme(text: str) -> Make:
    """Adds a README."""

    def make(workshop: Workshop) -> Path:
        folder = workshop.copy("random")
        (folder / "README.md").write_text(text, encoding="utf-8")
        return folder

    return make


def entry_named(name: str) -> Make:
    """Names the folder of the entry."""
    return lambda workshop: workshop.copy("random", name)


def other_group(workshop: Workshop) -> Path:
    """Presents a group as another one."""
    folder = workshop.copy("random")
    (folder / "hopper-motor-noise").rename(folder / "walker2d-motor-noise")
    return folder


def unknown_group(workshop: Workshop) -> Path:
    folder = workshop.copy("random")
    (folder / "hopper-motor-noise").rename(folder / "hopper-easy")
    return folder


ABOUT_PEOPLE = (
    "Knowledge of people: owners of entries are named in CODEOWNERS, and a challenge can doubt them."
)
ATTACKS = (
    stated(
        "The title has a character that turns the text around.",
        "title",
        '"TRPO \\u202e1 knar"',
        "rules: control-character",
    ),
    stated("The title has invisible characters.", "title", '"TRPO\\u200b"', "rules: control-character"),
    stated("The title is empty.", "title", '" "', "rules: empty-title"),
    stated("Combining marks cover the row above.", "title", f'"T{"̈" * 9}"', "rules: stacked-marks"),
    stated("The address of the code is a script.", "url", '"javascript:alert(1)"', "rules: bad-value"),
    stated(
        "The evaluation is neither sampled nor deterministic.", "evaluation", '"best"', "rules: bad-value"
    ),
    Attack(
        "The manifest has a key of its own.",
        submission(appended('level = "reproduced"')),
        "rules: unknown-key",
        quick=True,
    ),
    Attack(
        "A log is presented as a published table.",
        submission(appended('reported = "henderson2017"')),
        "rules: foreign-report, logs-of-a-reported-entry",
        quick=True,
    ),
    Attack(
        "The README has characters that hide text.",
        submission(readme("Fine\u202e.\n")),
        "rules: readme-character",
        quick=True,
    ),
    Attack(
        "The folder has the name of a device.",
        submission(entry_named("nul")),
        "rules: folder-name",
        quick=True,
    ),
    Attack(
        "The folder's name has a letter that looks like another.",
        submission(entry_named("trрo")),
        "rules: folder-name",
        quick=True,
    ),
    Attack(
        "The log is that of another group.",
        submission(other_group),
        "rules: foreign-task, missing-cell, unexpected-name, unsorted-rows",
        quick=True,
    ),
    Attack(
        "The group is an easier one of the author's own.",
        submission(unknown_group),
        "rules: unknown-group",
        quick=True,
    ),
    believed(
        "The title and the authors are those of a known laboratory.",
        "authors",
        '["A known laboratory"]',
        ABOUT_PEOPLE,
    ),
    believed("One author submits under two names.", "authors", '["Second account"]', ABOUT_PEOPLE),
    believed(
        "Tuning is said to have cost nothing.", "tasks", "[]", "Records of all trials, which nobody has."
    ),
    believed(
        "The agent is said to store fewer transitions.",
        "stored_steps",
        "0",
        "Retraining with a limit on memory.",
    ),
    believed(
        "The code is said to be at an address that has other code.",
        "url",
        '"https://example.org/other"',
        "Retraining from that address.",
    ),
)

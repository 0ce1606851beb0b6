"""Rules about the characters of the strings in submission.toml."""

from __future__ import annotations

from pathlib import Path

import pytest

from gym_extensions.rollouts.reader import read

from ..examples import GROUP, TOML, Check, CopySubmission, Example, edit, parametrize

EXAMPLES = (
    *(
        Example(
            "empty-title",
            f"a title of {name}",
            edit("An entry", title, TOML),
            ((f"{TOML}, title", f"The title {title!r} has no visible character.", "Name the entry."),),
            also=also,
        )
        for name, title, also in (
            ("spaces", "   ", ()),
            ("a letter without a glyph", "\u3164", ("control-character",)),
        )
    ),
    *(
        Example(
            "control-character",
            f"a title that looks like another one: {name}",
            edit("An entry", title, TOML),
            ((f"{TOML}, title", f"{title!r} contains a control or invisible character.", "Remove it."),),
        )
        for name, title in (
            ("a space of no width", "TR\u200bPO"),
            ("a soft hyphen", "TR\u00adPO"),
            ("a joiner between Latin letters", "TR\u200dPO"),
            ("a tag", "TRPO\U000e0041"),
            ("a mark that joins", "TR\u034fPO"),
        )
    ),
    Example(
        "control-character",
        "a right-to-left override in the title",
        edit("An entry", "An \\u202eentry", TOML),
        (
            (
                f"{TOML}, title",
                "'An \\u202eentry' contains a control or invisible character.",
                "Remove it.",
            ),
        ),
    ),
    Example(
        "control-character",
        "an escape sequence in the title",
        edit("An entry", "An \\u001b[31mentry", TOML),
        (
            (
                f"{TOML}, title",
                "'An \\x1b[31mentry' contains a control or invisible character.",
                "Remove it.",
            ),
        ),
    ),
    Example(
        "control-character",
        "a title of two lines",
        edit("An entry", "An entry\\n  (replayed)", TOML),
        (
            (
                f"{TOML}, title",
                "'An entry\\n  (replayed)' contains a control or invisible character.",
                "Remove it.",
            ),
        ),
    ),
    Example(
        "control-character",
        "an escape sequence in a key",
        edit("step = 0.01", '"\\u001b[31mstep" = nan', TOML),
        (
            (
                f"{TOML}, hyperparameters",
                "'\\x1b[31mstep' contains a control or invisible character.",
                "Remove it.",
            ),
        ),
        also=("bad-hyperparameter",),
    ),
)


@parametrize(EXAMPLES)
def test_the_rule_reports_these_problems_and_no_other(example: Example, check: Check) -> None:
    check(example)


@pytest.mark.parametrize(
    "title",
    [
        "Überprüft: “R₂”",
        "👩\u200d🔬 TRPO",
        "TRPO\u00a0v2",
        "強化\u3000学習",
        "می\u200cخواهم",
        "\U0001fae8",
    ],
)
def test_titles_in_every_language_are_valid(good: CopySubmission, tmp_path: Path, title: str) -> None:
    folder = good(GROUP, tmp_path)
    edit("An entry", title, TOML)(folder)
    assert read(folder).problems == ()


def test_the_description_may_have_line_breaks_and_tabs(good: CopySubmission, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    edit("Made up by a formula.", "Made up\\n\\tby a formula.", TOML)(folder)
    assert read(folder).problems == ()

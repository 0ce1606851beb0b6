"""Rules about the characters of the strings in submission.toml."""

from __future__ import annotations

from pathlib import Path

import pytest

from gym_extensions.rollouts.reader import read

from ..examples import GROUP, TOML, Check, CopySubmission, Example, edit, parametrize, put

README = "README.md"

STACKED = "o" + "\u0301" * 6

EXAMPLES = (
    Example(
        "stacked-marks",
        "a title with six marks on a letter",
        edit("An entry", STACKED, TOML),
        ((f"{TOML}, title", f"{STACKED!r} has combining marks that cover other texts.", "Remove them."),),
    ),
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
    Example(
        "readme-encoding",
        "a README in Latin-1",
        put(README, "# Entry\n\nTrained in Z\xfcrich.\n".encode("latin-1")),
        ((f"{README}, line 3", "Byte 0xfc is not UTF-8.", "Save the file as UTF-8."),),
    ),
    *(
        Example(
            "readme-character",
            f"a README with {name}",
            put(README, f"# Entry\r\n\r\n\tTR{char}PO\r\n".encode()),
            (
                (
                    f"{README}, line 3",
                    f"The line contains the control or invisible character U+{ord(char):04X}.",
                    "Remove it.",
                ),
            ),
        )
        for name, char in (
            ("a right-to-left override", "\u202e"),
            ("an isolate", "\u2067"),
            ("an escape sequence", "\x1b"),
            ("a carriage return inside a line", "\r"),
            ("a space of no width", "\u200b"),
        )
    ),
    Example(
        "readme-character",
        "a README with a byte order mark and more lines with NUL than are listed",
        put(README, "\ufeff# Entry\n\0\n\0\n\0\n\0\n".encode()),
        (
            *(
                (
                    f"{README}, line {line}",
                    f"The line contains the control or invisible character U+{code}.",
                    "Remove it.",
                )
                for line, code in ((1, "FEFF"), (2, "0000"), (3, "0000"))
            ),
            (README, "2 more lines contain such characters.", "Remove them."),
        ),
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


def test_the_text_of_the_readme_is_read_as_it_is_but_for_its_line_ends(
    good: CopySubmission, tmp_path: Path
) -> None:
    folder = good(GROUP, tmp_path)
    put(README, "# Überblick\r\n\r\n\t<b>強化</b> 👩\u200d🔬\n".encode())(folder)
    submission = read(folder)
    assert submission.problems == ()
    assert submission.readme == "# Überblick\n\n\t<b>強化</b> 👩\u200d🔬\n"

"""Every rule about submission.toml and README.md reports its mistake."""

import shutil
from pathlib import Path

import msgspec
import pytest

from gym_extensions.submissions.manifest import manifest_of, parse
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.rules.manifest import findings, hyperparameter_error, skeleton

from ..examples import GROUP, TOML, Change, CopySubmission, Example, all_of, edit, put

SUBMISSIONS = Path(__file__).parents[3] / "submissions"
README = "README.md"
STACKED = "o" + "\u0301" * 6
MARK = b"\xef\xbb\xbf"


def value(old: str, new: str) -> Change:
    return edit(old, new, TOML)


def title(text: str) -> Change:
    return value("A submission", text)


def alone(folder: Path) -> None:
    shutil.rmtree(folder / GROUP)


REPORTED = value("format = 1", 'format = 1\nreported = "henderson2017"')

EXAMPLES = (
    Example(
        "unknown-key", "a misspelt key", value("[code]", 'tittle = "x"\n[code]'), f"{TOML}, tittle", "'title'"
    ),
    Example(
        "unknown-key",
        "a misspelt key of a section",
        value("boundaries =", "boundarys ="),
        f"{TOML}, [observes] boundarys",
        "Did you mean 'boundaries'",
        also=("missing-key",),
    ),
    *(
        Example("missing-key", title, value(text, ""), f"{TOML}, {key}", "missing")
        for title, text, key in (
            ("no title", 'title = "A submission"\n', "title"),
            ("no format", "format = 1\n", "format"),
            ("no tuning", "[tuning]\nsteps = 0\ntasks = []\n", "tuning"),
            ("half of it", "tasks = []\n", "[tuning] tasks"),
        )
    ),
    *(
        Example("bad-value", title, value(old, new), f"{TOML}, {key}", fact)
        for title, old, new, key, fact in (
            ("another format", "format = 1", "format = 2", "format", "The value is 2"),
            ("no such budget", '"smoke"', '"smokes"', "[protocol] budget", "'smoke'"),
            ("a number for a text", '"A submission"', "7", "title", "7"),
            ("no flag", "boundaries = false", 'boundaries = "no"', "[observes] boundaries", "true or false"),
            ("a flag for a number", "steps = 0", "steps = true", "[tuning] steps", "integer from 0"),
            ("a negative number", "steps = 0", "steps = -1", "[tuning] steps", "integer from 0"),
            ("an author without a name", '["A. Nonymous"]', '[""]', "authors", "1 to 100"),
            ("a script", 'url = ""', 'url = "javascript:x"', "[code] url", "https://"),
            ("a host like another", 'url = ""', 'url = "https://gіthub.com"', "[code] url", "ASCII"),
            ("an infinite setting", "= 0.01", "= inf", "[hyperparameters] step", "is not finite"),
            ("a table as a setting", "= 0.01", "= {a = 1}", "[hyperparameters] step", "dict"),
        )
    ),
    Example(
        "bad-value",
        "a text for a section",
        all_of(value('[code]\nurl = ""\ncommit = ""\n', ""), value("format = 1", 'format = 1\ncode = "x"')),
        f"{TOML}, code",
        "[code]",
    ),
    Example(
        "unknown-report",
        "a table that does not exist",
        all_of(alone, value("format = 1", 'format = 1\nreported = "henderson2018"')),
        f"{TOML}, reported",
        "henderson2017",
    ),
    Example(
        "unknown-report",
        "a table under another name, budget and algorithm",
        all_of(alone, REPORTED),
        "submission",
        "belongs to the folder 'henderson2017-trpo'",
        count=3,
    ),
    Example("no-groups", "a manifest alone", alone, "submission", "no group folder"),
    Example("no-groups", "a table with logs", REPORTED, GROUP, "cannot contain", also=("unknown-report",)),
    Example("mixed-scripts", "Cyrillic letters", title("ТRPО"), f"{TOML}, title", "look alike"),
    Example("empty-title", "spaces", title("   "), f"{TOML}, title", "no visible character"),
    Example(
        "empty-title", "no glyph", title("\u3164"), f"{TOML}, title", "visible", also=("control-character",)
    ),
    *(
        Example("control-character", name, title(text), f"{TOML}, title", "invisible")
        for name, text in (
            ("a space of no width", "TR\u200bPO"),
            ("a soft hyphen", "TR\u00adPO"),
            ("a joiner between Latin letters", "TR\u200dPO"),
            ("a tag", "TRPO\U000e0041"),
            ("a mark that joins", "TR\u034fPO"),
            ("a right-to-left override", "An \\u202esubmission"),
            ("a line break", "An\\nsubmission"),
        )
    ),
    Example("readme-character", "not UTF-8", put(README, b"a\nb\xff"), f"{README}, line 2", "0xff"),
    Example(
        "readme-character", "an escape sequence", put(README, b"a\nb\x1b[2J"), f"{README}, line 2", "U+001B"
    ),
    Example("readme-character", "stacked marks", put(README, STACKED.encode()), f"{README}, line 1", "cover"),
    Example("readme-character", "many", put(README, b"\x00\n" * 9), f"{README}, line 1", "U+0000", count=4),
)


def test_all_mistakes_of_a_manifest_are_reported_at_once(good: CopySubmission, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    all_of(value('"smoke"', '"x"'), value("boundaries = false", "boundaries = 1"), title("\u200b"))(folder)
    rules = {problem.rule for problem in read(folder).problems}
    assert rules == {"bad-value", "control-character", "empty-title"}


def test_a_byte_order_mark_before_the_manifest_is_read_over(good: CopySubmission, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    (folder / TOML).write_bytes(MARK + (folder / TOML).read_bytes())
    submission = read(folder)
    assert submission.problems == ()
    assert submission.manifest is not None
    assert submission.manifest.title == "A submission"


@pytest.mark.parametrize("text", ["強化学習", "تعلّم", "می‌خواهم", "क्षत्रिय", "Việt", "🧗‍♀️ climb"])
def test_texts_in_every_language_and_line_breaks_in_the_description_are_valid(
    good: CopySubmission, tmp_path: Path, text: str
) -> None:
    folder = good(GROUP, tmp_path)
    all_of(title(text), value("Made up by a formula.", "One.\\n\\tTwo."))(folder)
    assert read(folder).problems == ()


def test_the_readme_is_read_as_it_is_but_for_its_line_ends(good: CopySubmission, tmp_path: Path) -> None:
    folder = good(GROUP, tmp_path)
    put(README, "# Wörter\r\n\tText\r\n".encode())(folder)
    assert read(folder).readme == "# Wörter\n\tText\n"


@pytest.mark.parametrize(
    ("setting", "error"),
    [
        ((64, 64), ""),
        ("x" * 4001, "has 4001 characters"),
        ([1] * 101, "has 101 elements"),
        ([[1]], "contains an element of type list"),
        (float("nan"), "is not finite"),
        (2**63, "is too large"),
        (None, "is of type NoneType"),
    ],
)
def test_what_a_hyperparameter_may_be(setting: object, error: str) -> None:
    assert hyperparameter_error(setting).startswith(error)
    assert bool(hyperparameter_error(setting)) == bool(error)


@pytest.mark.committed
@pytest.mark.parametrize("path", sorted(SUBMISSIONS.glob("*/submission.toml")), ids=lambda p: p.parent.name)
def test_a_committed_manifest_is_read_whole(path: Path) -> None:
    tables = parse(path.read_bytes())
    assert list(findings(tables)) == []
    read = msgspec.json.decode(msgspec.json.encode(manifest_of(tables)))
    for name, value in tables.items():
        assert read[name] == (read[name] | value if isinstance(value, dict) else value), name


@pytest.mark.parametrize("text", ["β-VAE", "強化学習とTRPO", "Обучение с TRPO", "naïve Bayes"])
def test_words_of_one_script_may_be_of_any(good: CopySubmission, tmp_path: Path, text: str) -> None:
    folder = good(GROUP, tmp_path)
    title(text)(folder)
    assert read(folder).problems == ()


def test_texts_that_look_alike_have_one_skeleton() -> None:
    same = ["TRPO", "trp0", "ТRРО", "ΤRΡΟ", "T R P O"]
    assert {skeleton(text) for text in same} == {"trpo"}
    assert skeleton("modern l2") == skeleton("modem I2") != skeleton("modern l1")

"""Every rule about submission.toml and README.md reports its mistake."""

import shutil
from pathlib import Path

import msgspec
import pytest

from gym_extensions.submissions.manifest import manifest_of, parse
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.rules.manifest import hyperparameter_error

from ...conftest import MANIFEST
from ..examples import GROUP, TOML, Change, Table, all_of, edit, put

SUBMISSIONS = Path(__file__).parents[3] / "submissions"
README = "README.md"
MARK = b"\xef\xbb\xbf"


def value(old: str, new: str) -> Change:
    return edit(old, new, TOML)


def title(text: str) -> Change:
    return value("A submission", text)


def alone(folder: Path) -> None:
    shutil.rmtree(folder / GROUP)


def reported(name: str) -> Change:
    return value("format = 1", f'format = 1\nreported = "{name}"')


def values(key: str, *rows: tuple[str, str, str, str]) -> list[tuple[object, ...]]:
    """Examples of one key: what is wrong, the text that is replaced, the new one, and what is said."""
    return [(title, value(old, new), f"{TOML}, {key}", fact) for title, old, new, fact in rows]


TITLE = f"{TOML}, title"
NO_SECTION = value('[code]\nurl = ""\ncommit = ""\n', "")
EXAMPLES: Table = {
    "unknown-key": [
        ("misspelt", value("[code]", 'tittle = "x"\n[code]'), f"{TOML}, tittle", "'title'"),
        (
            *("in a section", value("boundaries =", "boundarys ="), f"{TOML}, [observes] boundarys"),
            *("Did you mean 'boundaries'", ("missing-key",)),
        ),
    ],
    "missing-key": [
        *values("title", ("no title", 'title = "A submission"\n', "", "missing")),
        *values("format", ("no format", "format = 1\n", "", "missing")),
        *values("tuning", ("no tuning", "[tuning]\nsteps = 0\ntasks = []\n", "", "missing")),
        *values("[tuning] tasks", ("half of it", "tasks = []\n", "", "missing")),
    ],
    "bad-value": [
        *values("format", ("another format", "format = 1", "format = 2", "The value is 2")),
        *values("[protocol] budget", ("no such budget", '"smoke"', '"smokes"', "'smoke'")),
        *values("title", ("a number for a text", '"A submission"', "7", "7")),
        *values("[observes] boundaries", ("no flag", "ies = false", 'ies = "no"', "true or false")),
        *values(
            "[tuning] steps",
            ("a flag for a number", "steps = 0", "steps = true", "integer from 0"),
            ("a negative number", "steps = 0", "steps = -1", "integer from 0"),
        ),
        *values("authors", ("an author without a name", '["A. Nonymous"]', '[""]', "1 to 100")),
        *values(
            "[code] url",
            ("a script", 'url = ""', 'url = "javascript:x"', "https://"),
            ("a host like another", 'url = ""', 'url = "https://gіthub.com"', "ASCII"),
        ),
        *values(
            "[hyperparameters] step",
            ("an infinite setting", "= 0.01", "= inf", "is not finite"),
            ("a table as a setting", "= 0.01", "= {a = 1}", "dict"),
        ),
        (
            *("a text for a section", all_of(NO_SECTION, value("format = 1", 'format = 1\ncode = "x"'))),
            *(f"{TOML}, code", "[code]"),
        ),
    ],
    "unknown-report": [
        ("no table", all_of(alone, reported("henderson2018")), f"{TOML}, reported", "henderson2017"),
        (
            *("another name, budget and algorithm", all_of(alone, reported("henderson2017"))),
            *("submission", "belongs to the folder 'henderson2017-trpo'", (), 3),
        ),
    ],
    "no-groups": [
        ("a manifest alone", alone, "submission", "no group folder"),
        ("a table with logs", reported("henderson2017"), GROUP, "cannot contain", ("unknown-report",)),
    ],
    "script": [
        ("Cyrillic letters", title("ТRPО"), TITLE, "of several scripts"),
        ("a Hebrew letter", title("TRPס"), TITLE, "of several scripts"),
        ("Lisu letters", title("ꓔꓣꓑꓳ"), TITLE, "of another script"),
        ("one Lisu letter", title("TRPꓳ"), TITLE, "of another script"),
        ("Cherokee letters", title("ᏚᎪᏟ"), TITLE, "of another script"),
        (
            "Coptic letters of an algorithm",
            value('"formula"', '"ⲢⲢⲞ"'),
            f"{TOML}, algorithm",
            "of another script",
        ),
    ],
    "empty-title": [
        ("spaces", title("   "), TITLE, "no visible character"),
        ("no glyph", title("\u3164"), TITLE, "visible", ("control-character",)),
    ],
    "control-character": [
        ("a space of no width", title("TR\u200bPO"), TITLE, "invisible"),
        ("a soft hyphen", title("TR\u00adPO"), TITLE, "invisible"),
        ("a joiner between Latin letters", title("TR\u200dPO"), TITLE, "invisible"),
        ("joiners beside each other", title("TR\u200d\u200c\u200dPO"), TITLE, "invisible"),
        ("a selector of emoji", title("TR\ufe0fPO"), TITLE, "invisible"),
        ("a selector of variants", title("TR\U000e0100PO"), TITLE, "invisible"),
        ("a reserved character", title("TR\U000e0fffPO"), TITLE, "invisible"),
        ("a tag", title("TRPO\U000e0041"), TITLE, "invisible"),
        ("a mark that joins", title("TR\u034fPO"), TITLE, "invisible"),
        ("a right-to-left override", title("An \\u202esubmission"), TITLE, "invisible"),
        ("a line break", title("An\\nsubmission"), TITLE, "invisible"),
    ],
    "readme-character": [
        ("not UTF-8", put(README, b"a\nb\xff"), f"{README}, line 2", "0xff"),
        ("an escape sequence", put(README, b"a\nb\x1b[2J"), f"{README}, line 2", "U+001B"),
        ("stacked marks", put(README, ("o" + "\u0301" * 6).encode()), f"{README}, line 1", "cover"),
    ],
}


def test_all_mistakes_of_a_manifest_are_reported_at_once(folder: Path) -> None:
    all_of(value('"smoke"', '"x"'), value("boundaries = false", "boundaries = 1"), title("\u200b"))(folder)
    rules = {problem.rule for problem in read(folder).problems}
    assert rules == {"bad-value", "control-character", "empty-title"}


def test_the_digest_of_the_settings_stays_as_reviews_state_it() -> None:
    tables = parse(MANIFEST.encode())
    assert manifest_of(tables).digest.startswith("a4466c36969211a8")
    assert manifest_of(tables | {"title": "Another"}).digest == manifest_of(tables).digest
    assert manifest_of(tables | {"hyperparameters": {}}).digest != manifest_of(tables).digest


def test_a_byte_order_mark_before_the_manifest_is_read_over(folder: Path) -> None:
    (folder / TOML).write_bytes(MARK + (folder / TOML).read_bytes())
    submission = read(folder)
    assert submission.problems == ()
    assert submission.manifest is not None
    assert submission.manifest.title == "A submission"


LANGUAGES = ["強化学習とTRPO", "تعلّم", "می‌خواهم", "क्षत्रिय", "β-VAE", "Обучение с TRPO", "Việt", "🧗‍♀️ climb"]
LANGUAGES += [
    "佐々木コーチ",
    "ハワイʻi",
    "한국어 모델",
    "שלום",
    "ตัวแทน",
    "தமிழ்",
    "አማርኛ",
    "ქართული",
    "ℝ² ¹ªº № ™ µ",
    "\u0378",  # which Unicode may assign one day
]


@pytest.mark.parametrize("text", LANGUAGES)
def test_texts_in_every_language_and_line_breaks_in_the_description_are_valid(
    folder: Path, text: str
) -> None:
    all_of(title(text), value("Made up by a formula.", "One.\\n\\tTwo."))(folder)
    assert read(folder).problems == ()


def test_the_readme_is_read_as_it_is_but_for_its_line_ends(folder: Path) -> None:
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
    read = msgspec.json.decode(msgspec.json.encode(manifest_of(tables)))
    for name, value in tables.items():
        assert read[name] == (read[name] | value if isinstance(value, dict) else value), name

"""Rules about submission.toml."""

from __future__ import annotations

from ..examples import TOML, Check, Example, edit, parametrize

EXAMPLES = (
    Example(
        "foreign-version",
        "another version of MuJoCo",
        edit('mujoco = "4.0.0"', 'mujoco = "9.9"', TOML),
        (
            (
                f"{TOML}, [versions] mujoco",
                "The version is '9.9'; the published tasks have '4.0.0'.",
                "Record the episodes with mujoco 4.0.0.",
            ),
        ),
    ),
    Example(
        "malformed-toml",
        "a missing quote",
        edit('title = "An entry"', 'title = "An entry', TOML),
        (
            (
                TOML,
                "The file is not valid TOML: Illegal character '\\n' (at line 2, column 18).",
                "Correct the syntax; the format is described at https://toml.io.",
            ),
        ),
    ),
    Example(
        "malformed-toml",
        "bytes that are not UTF-8",
        lambda folder: (folder / TOML).write_bytes(b"\xff\xfe"),
        (
            (
                TOML,
                "The file is not valid TOML: 'utf-8' codec can't decode byte 0xff in position 0: "
                "invalid start byte.",
                "Correct the syntax; the format is described at https://toml.io.",
            ),
        ),
    ),
    Example(
        "unknown-key",
        "a misspelt key",
        edit("[code]", 'tittle = "Another"\n[code]', TOML),
        ((TOML, "Unknown key 'tittle'.", "Did you mean 'title'?"),),
    ),
    Example(
        "unknown-key",
        "a key of another section",
        edit("stored_steps = 2000", "stored_step = 1\nstored_steps = 2000", TOML),
        (
            (
                f"{TOML}, [memory] stored_step",
                "Unknown key 'stored_step'.",
                "Did you mean 'stored_steps'?",
            ),
        ),
    ),
    Example(
        "missing-key",
        "no statement on tuning",
        edit("[tuning]\nsteps = 0\ntasks = []\n", "", TOML),
        (
            (f"{TOML}, [tuning] steps", "The key is missing.", "Add the key steps: an integer from 0."),
            (f"{TOML}, [tuning] tasks", "The key is missing.", "Add the key tasks: a list of strings."),
        ),
    ),
    Example(
        "missing-key",
        "a missing key",
        edit("boundaries = false\n", "", TOML),
        (
            (
                f"{TOML}, [observes] boundaries",
                "The key is missing.",
                "Add the key boundaries: true or false.",
            ),
        ),
    ),
    Example(
        "bad-value",
        "a string in place of a number",
        edit("stored_steps = 2000", 'stored_steps = "2000"', TOML),
        (
            (
                f"{TOML}, [memory] stored_steps",
                "'2000' is not an integer from 0 to 2⁵³ − 1.",
                "Write an integer from 0.",
            ),
        ),
    ),
    Example(
        "bad-value",
        "a URL that a browser would execute",
        edit('url = ""', 'url = "javascript:alert(1)"', TOML),
        (
            (
                f"{TOML}, [code] url",
                "'javascript:alert(1)' is not a web address in ASCII that starts with https:// or http://.",
                "Write a web address or an empty string.",
            ),
        ),
    ),
    Example(
        "bad-value",
        "an unknown evaluation",
        edit('"sampled"', '"sample"', TOML),
        ((f"{TOML}, [protocol] evaluation", "The value is 'sample'.", "Did you mean 'sampled'?"),),
    ),
    Example(
        "bad-package",
        "a version that is a number",
        edit("[tuning]", '[packages]\ntorch = 2.13\njax = "0.10.2"\n\n[tuning]', TOML),
        ((f"{TOML}, [packages] torch", "2.13 is not a string.", "Write a string."),),
    ),
    Example(
        "bad-package",
        "another version of a package of [versions]",
        edit("[tuning]", '[packages]\nmujoco = "3.0.0"\n\n[tuning]', TOML),
        ((f"{TOML}, [packages] mujoco", "'mujoco' is a key of [versions].", "Remove it."),),
    ),
    Example(
        "bad-value",
        "a value where a section belongs",
        lambda folder: (
            edit('[code]\nurl = ""\ncommit = ""\n', "", TOML)(folder)
            or edit("format = 1", 'format = 1\ncode = "https://example.org"', TOML)(folder)
        ),
        ((f"{TOML}, code", "'https://example.org' is not a section.", "Write [code] and its keys."),),
    ),
    Example(
        "bad-value",
        "a misspelt budget",
        edit('"smoke"', '"smok"', TOML),
        ((f"{TOML}, [protocol] budget", "The value is 'smok'.", "Did you mean 'smoke'?"),),
    ),
    Example(
        "unknown-report",
        "an unknown published table",
        edit("format = 1", 'format = 1\nreported = "henderson2018"', TOML),
        ((f"{TOML}, reported", "Unknown table 'henderson2018'.", "Did you mean 'henderson2017'?"),),
        also=("logs-of-a-reported-entry",),
    ),
    Example(
        "bad-hyperparameter",
        "an integer with too many digits to print",
        edit("step = 0.01", f"step = 0x{'f' * 6000}", TOML),
        (
            (
                f"{TOML}, [hyperparameters] step",
                "An integer with too many digits to print is too large.",
                "Write a string, a finite number, true or false, or a list of them.",
            ),
        ),
    ),
    Example(
        "malformed-toml",
        "thousands of nested lists",
        edit("step = 0.01", f"step = {'[' * 5000}", TOML),
        (
            (
                TOML,
                "Tables, lists or keys are nested too deeply.",
                "Use at most 8 levels.",
            ),
        ),
    ),
    Example(
        "malformed-toml",
        "thousands of nested tables",
        edit("step = 0.01", f"{'a.' * 3000}step = 0.01", TOML),
        ((TOML, "Tables, lists or keys are nested too deeply.", "Use at most 8 levels."),),
    ),
    Example(
        "bad-hyperparameter",
        "a table among the hyperparameters",
        edit("step = 0.01", "step = {first = 1}", TOML),
        (
            (
                f"{TOML}, [hyperparameters] step",
                "{'first': 1} is of type dict.",
                "Write a string, a finite number, true or false, or a list of them.",
            ),
        ),
    ),
    Example(
        "bad-hyperparameter",
        "long lists and strings, nested lists, an infinite number",
        edit("step = 0.01", f"a = {[1] * 101}\nb = '{'x' * 4001}'\nc = [[1]]\nd = inf", TOML),
        (
            (
                f"{TOML}, [hyperparameters] a",
                f"[{'1, ' * 26}1… has 101 elements; the limit is 100.",
                "Write a string, a finite number, true or false, or a list of them.",
            ),
            (
                f"{TOML}, [hyperparameters] b",
                f"'{'x' * 79}… has 4001 characters; the limit is 4000.",
                "Write a string, a finite number, true or false, or a list of them.",
            ),
            (
                f"{TOML}, [hyperparameters] c",
                "[[1]] contains an element of type list.",
                "Write a string, a finite number, true or false, or a list of them.",
            ),
            (
                f"{TOML}, [hyperparameters] d",
                "inf is not finite.",
                "Write a string, a finite number, true or false, or a list of them.",
            ),
        ),
    ),
    Example(
        "bad-value",
        "a malformed digest",
        edit("[versions]", '[archive]\nurl = ""\nsha256 = "z"\n[versions]', TOML),
        (
            (
                f"{TOML}, [archive] sha256",
                "'z' is not 64 hexadecimal digits (0 to 9, a to f).",
                "Write a SHA-256 digest of 64 hexadecimal digits, or an empty string.",
            ),
        ),
    ),
    Example(
        "bad-value",
        "a URL with user information",
        edit('url = ""', 'url = "https://example.org@example.com/x"', TOML),
        (
            (
                f"{TOML}, [code] url",
                "'https://example.org@example.com/x' is not a web address in ASCII that starts with "
                "https:// or http://.",
                "Write a web address or an empty string.",
            ),
        ),
    ),
    Example(
        "unknown-key",
        "a key with an escape sequence and one of thousands of letters",
        edit("[code]", f'[code]\n"\\u001b[31m" = 1\n{"k" * 3000} = 1', TOML),
        (
            (
                f"{TOML}, [code] '\\x1b[31m'",
                "Unknown key '\\x1b[31m'.",
                "Choose one of: commit, url.",
            ),
            (
                f"{TOML}, [code] '{'k' * 79}…",
                f"Unknown key '{'k' * 79}….",
                "Choose one of: commit, url.",
            ),
        ),
        also=("control-character",),
    ),
)


@parametrize(EXAMPLES)
def test_the_rule_reports_these_problems_and_no_other(example: Example, check: Check) -> None:
    check(example)

"""Rules about submission.toml."""

from __future__ import annotations

from .broken import TOML, Broken, Judge, each, edit

BROKEN = (
    Broken(
        "malformed-toml",
        "a missing quote",
        edit('title = "An entry"', 'title = "An entry', TOML),
        (
            (
                TOML,
                "It is not TOML: Illegal character '\\n' (at line 2, column 18).",
                "Correct that place; the format is at https://toml.io.",
            ),
        ),
    ),
    Broken(
        "malformed-toml",
        "bytes that are no UTF-8",
        lambda folder: (folder / TOML).write_bytes(b"\xff\xfe"),
        (
            (
                TOML,
                "It is not TOML: 'utf-8' codec can't decode byte 0xff in position 0: invalid start byte.",
                "Correct that place; the format is at https://toml.io.",
            ),
        ),
    ),
    Broken(
        "unknown-key",
        "a misspelt key",
        edit("[code]", 'tittle = "Another"\n[code]', TOML),
        ((TOML, "There is no key 'tittle'.", "Did you mean 'title'?"),),
    ),
    Broken(
        "unknown-key",
        "a key of another section",
        edit("stored_steps = 2000", "stored_step = 1\nstored_steps = 2000", TOML),
        (
            (
                f"{TOML}, [memory] stored_step",
                "There is no key 'stored_step'.",
                "Did you mean 'stored_steps'?",
            ),
        ),
    ),
    Broken(
        "missing-key",
        "what the agent knows is left out",
        edit("boundaries = false\n", "", TOML),
        (
            (
                f"{TOML}, [observes] boundaries",
                "The key is missing.",
                "Add boundaries with a value: true or false.",
            ),
        ),
    ),
    Broken(
        "bad-value",
        "a text in place of a number",
        edit("stored_steps = 2000", 'stored_steps = "2000"', TOML),
        (
            (
                f"{TOML}, [memory] stored_steps",
                "'2000' is not a whole number from 0 to 2⁵³ − 1.",
                "Give a whole number.",
            ),
        ),
    ),
    Broken(
        "bad-value",
        "an address that a browser would run",
        edit('url = ""', 'url = "javascript:alert(1)"', TOML),
        (
            (
                f"{TOML}, [code] url",
                "'javascript:alert(1)' is not an address that begins with https:// or http://.",
                "Give a web address, or an empty text.",
            ),
        ),
    ),
    Broken(
        "bad-value",
        "another evaluation",
        edit('"sampled"', '"sample"', TOML),
        ((f"{TOML}, [protocol] evaluation", "The value is 'sample'.", "Did you mean 'sampled'?"),),
    ),
    Broken(
        "bad-value",
        "a value where a section belongs",
        lambda folder: (
            edit('[code]\nurl = ""\ncommit = ""\n', "", TOML)(folder)
            or edit("format = 1", 'format = 1\ncode = "https://example.org"', TOML)(folder)
        ),
        ((f"{TOML}, code", "'https://example.org' is not a section.", "Write [code] and its keys."),),
    ),
    Broken(
        "unknown-budget",
        "a misspelt budget",
        edit('"smoke"', '"smok"', TOML),
        ((f"{TOML}, [protocol] budget", "There is no budget 'smok'.", "Did you mean 'smoke'?"),),
    ),
    Broken(
        "unknown-report",
        "a table that the project does not keep",
        edit("format = 1", 'format = 1\nreported = "henderson2018"', TOML),
        ((f"{TOML}, reported", "There is no table 'henderson2018'.", "Did you mean 'henderson2017'?"),),
        also=("logs-of-a-reported-entry",),
    ),
    Broken(
        "bad-hyperparameter",
        "a number of more digits than can be printed",
        edit("step = 0.01", f"step = 0x{'f' * 6000}", TOML),
        (
            (
                f"{TOML}, [hyperparameters] step",
                "a number of very many digits is too large.",
                "Give a text, a finite number, true or false, or a list of them.",
            ),
        ),
    ),
    Broken(
        "malformed-toml",
        "lists within lists without end",
        edit("step = 0.01", f"step = {'[' * 5000}", TOML),
        (
            (
                TOML,
                "Its tables or lists are nested too deeply.",
                "At most 8 may stand in one another.",
            ),
        ),
    ),
    Broken(
        "malformed-toml",
        "tables within tables",
        edit("step = 0.01", f"{'a.' * 3000}step = 0.01", TOML),
        ((TOML, "Its tables or lists are nested too deeply.", "At most 8 may stand in one another."),),
    ),
    Broken(
        "bad-hyperparameter",
        "a table among the hyperparameters",
        edit("step = 0.01", "step = {first = 1}", TOML),
        (
            (
                f"{TOML}, [hyperparameters] step",
                "{'first': 1} is of another kind.",
                "Give a text, a finite number, true or false, or a list of them.",
            ),
        ),
    ),
    Broken(
        "bad-hyperparameter",
        "lists and texts without end, and lists within lists",
        edit("step = 0.01", f"a = {[1] * 101}\nb = '{'x' * 4001}'\nc = [[1]]\nd = inf", TOML),
        (
            (
                f"{TOML}, [hyperparameters] a",
                f"[{'1, ' * 26}1… has 101 elements; 100 are allowed.",
                "Give a text, a finite number, true or false, or a list of them.",
            ),
            (
                f"{TOML}, [hyperparameters] b",
                f"'{'x' * 79}… has 4001 characters; 4000 are allowed.",
                "Give a text, a finite number, true or false, or a list of them.",
            ),
            (
                f"{TOML}, [hyperparameters] c",
                "[[1]] is of another kind.",
                "Give a text, a finite number, true or false, or a list of them.",
            ),
            (
                f"{TOML}, [hyperparameters] d",
                "inf is not finite.",
                "Give a text, a finite number, true or false, or a list of them.",
            ),
        ),
    ),
    Broken(
        "bad-value",
        "a digest that is none",
        edit("[versions]", '[archive]\nurl = ""\nsha256 = "z"\n[versions]', TOML),
        (
            (
                f"{TOML}, [archive] sha256",
                "'z' is not 64 digits of 0 to 9 and a to f.",
                "Give a sha256 in 64 hexadecimal digits, or an empty text.",
            ),
        ),
    ),
    Broken(
        "bad-value",
        "an address whose host is not what it seems",
        edit('url = ""', 'url = "https://example.org@example.com/x"', TOML),
        (
            (
                f"{TOML}, [code] url",
                "'https://example.org@example.com/x' is not an address that begins with https:// or http://.",
                "Give a web address, or an empty text.",
            ),
        ),
    ),
    Broken(
        "unknown-key",
        "a key with an escape sequence and one of thousands of letters",
        edit("[code]", f'[code]\n"\\u001b[31m" = 1\n{"k" * 3000} = 1', TOML),
        (
            (
                f"{TOML}, [code] '\\x1b[31m'",
                "There is no key '\\x1b[31m'.",
                "Choose one of: commit, url.",
            ),
            (
                f"{TOML}, [code] '{'k' * 79}…",
                f"There is no key '{'k' * 79}….",
                "Choose one of: commit, url.",
            ),
        ),
        also=("control-character",),
    ),
)


@each(BROKEN)
def test_a_broken_folder_breaks_its_rule_and_says_so(example: Broken, judge: Judge) -> None:
    judge(example)

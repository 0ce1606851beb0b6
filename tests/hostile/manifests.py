"""Hostile texts of submission.toml and README.md."""

from __future__ import annotations

from .case import TOML, Case, edit, manifest, put, value

SECTIONS = "".join(f"[s{index}]\n" for index in range(20_000))
ZALGO = "o" + "\u0301" * 90
TOO_DEEP, NO_TOML = ("malformed-toml",), ("malformed-toml",)

CASES = (
    Case("one dotted key of 60,000 parts", put(TOML, b"a" + b".a" * 60_000 + b" = 1\n"), TOO_DEEP),
    Case("a dotted key with spaces", put(TOML, b"a" + b" . a" * 30_000 + b" = 1\n"), TOO_DEEP),
    Case("a dotted key of strings", put(TOML, b'"a"' + b'."."' * 20_000 + b" = 1\n"), TOO_DEEP),
    Case("a dotted key of literal strings", put(TOML, b"'a'" + b".'='" * 20_000 + b" = 1\n"), TOO_DEEP),
    Case("a dotted key in an inline table", put(TOML, b"x = {a" + b".a" * 60_000 + b" = 1}\n"), TOO_DEEP),
    Case(
        "a dotted key after four quotes",
        put(TOML, b'x = [{y = """z"""", a' + b".a" * 60_000 + b" = 1}]\n"),
        TOO_DEEP,
    ),
    Case(
        "a dotted key after a quoted quote",
        put(TOML, b"x = [{y = '\"', a" + b".a" * 60_000 + b" = 1}]\n"),
        TOO_DEEP,
    ),
    Case("a dotted header", put(TOML, b"[a" + b".a" * 60_000 + b"]\n"), TOO_DEEP),
    Case("a dotted header of an array of tables", put(TOML, b"[[a" + b".a" * 60_000 + b"]]\n"), TOO_DEEP),
    Case(
        "dotted keys of nine parts in 10,000 rows",
        put(TOML, b"".join(b"a.b.c.d.e.f.g.h.i%d = 1\n" % i for i in range(10_000))),
        TOO_DEEP,
    ),
    Case(
        "dotted keys of seven parts in 9,000 rows",
        put(TOML, b"".join(b"a.b.c.d.e.f.i%d = 1\n" % i for i in range(9_000))),
        ("missing-key", "unknown-key"),
    ),
    Case("60,000 nested lists", put(TOML, b"a = " + b"[" * 60_000), TOO_DEEP),
    Case("nested lists that are closed", put(TOML, b"a = " + b"[" * 60_000 + b"]" * 60_000), TOO_DEEP),
    Case("nested inline tables", put(TOML, b"a = " + b"{a=" * 60_000), TOO_DEEP),
    Case("nine levels of lists", manifest("x = [[[[[[[[[1]]]]]]]]]\n", "hyperparameters"), TOO_DEEP),
    Case("20,000 sections", manifest(SECTIONS), ("unknown-key",)),
    Case("20,000 tables of an array", manifest("[[x]]\n" * 20_000), ("unknown-key",)),
    Case(
        "20,000 unknown keys",
        manifest("".join(f"k{i} = 1\n" for i in range(20_000)), "code"),
        ("unknown-key",),
    ),
    Case(
        "15,000 hyperparameters",
        manifest("".join(f"k{i} = 1\n" for i in range(15_000)), "hyperparameters"),
    ),
    Case(
        "10,000 wrong hyperparameters",
        manifest("".join(f"k{i} = nan\n" for i in range(15_000)), "hyperparameters"),
        ("bad-hyperparameter",),
    ),
    Case("unterminated strings in 40,000 rows", put(TOML, b'"""\n\\' * 40_000), NO_TOML),
    Case("quotes alone", put(TOML, b'"' * 250_000), NO_TOML),
    Case("quotes and backslashes", put(TOML, b'x = "' + b'\\"' * 120_000), NO_TOML),
    Case("apostrophes alone", put(TOML, b"'" * 250_000), NO_TOML),
    Case("dots alone", put(TOML, b"." * 250_000), TOO_DEEP),
    Case("a comment of 250,000 dots", manifest("# " + "." * 200_000 + "\n"), ()),
    Case("a string of 200,000 dots", value("title", '"' + "." * 200_000 + '"'), ("bad-value",)),
    Case("an integer of 200,000 digits", value("parameters_last", "9" * 200_000), NO_TOML),
    Case(
        "a hexadecimal integer of 200,000 digits",
        value("parameters_last", "0x" + "f" * 200_000),
        ("bad-value",),
    ),
    Case(
        "a hyperparameter of 200,000 digits",
        manifest("x = 0x" + "f" * 200_000, "hyperparameters"),
        ("bad-hyperparameter",),
    ),
    Case("a float of 200,000 digits", manifest("x = 0." + "9" * 200_000, "hyperparameters"), ()),
    Case("a number of underscores", manifest("x = 1" + "_1" * 60_000, "hyperparameters"), NO_TOML),
    Case(
        "a date without an end",
        manifest("x = 1979-05-27T07:32:00." + "0" * 200_000, "hyperparameters"),
        ("bad-hyperparameter",),
    ),
    Case("a manifest of 256 KiB and a byte", put(TOML, b"#" * (2**18 + 1)), ("too-large",)),
    Case("a manifest of null bytes", put(TOML, bytes(2**18)), NO_TOML),
    Case("a manifest in UTF-16", put(TOML, "format = 1\n".encode("utf-16")), NO_TOML),
    Case("surrogates", put(TOML, b'title = "\xed\xa0\x80"\n'), NO_TOML),
    Case("a title of escapes", value("title", '"\\u0000\\u0000"'), ("control-character", "empty-title")),
    Case("a title that moves the cursor", value("title", '"\\u001b[2J"'), ("control-character",)),
    Case("a title that turns the text", value("title", '"\\u202egnp.exe"'), ("control-character",)),
    Case("a title of combining marks", value("title", f'"{ZALGO}"'), ("stacked-marks",)),
    Case("a title that starts with a mark", value("title", '"\\u0301Entry"'), ("stacked-marks",)),
    Case("an author of combining marks", value("authors", f'["{ZALGO}"]'), ("stacked-marks",)),
    Case("a description of combining marks", value("description", f'"{ZALGO}"'), ("stacked-marks",)),
    Case("a title of tags", value("title", '"<script>alert(1)</script>"'), (), "pages"),
    Case("a title of Tibetan stacks", value("title", '"བསྒྲུབས་ ཧཱུྃ"'), ()),
    Case("a title of Thai and Vietnamese", value("title", '"ที่นี่ ệ Việt"'), ()),
    Case(
        "a description of 200,000 characters", value("description", '"' + "x" * 200_000 + '"'), ("bad-value",)
    ),
    Case("10,000 authors", value("authors", "[" + '"a",' * 40_000 + "]"), ("bad-value",)),
    Case("a host with a Cyrillic letter", value("url", '"https://gіthub.com/x"'), ("bad-value",)),
    Case("a host with a full-width letter", value("url", '"https://ｇithub.com"'), ("bad-value",)),
    Case("a host after a user's name", value("url", '"https://github.com@example.org"'), ("bad-value",)),
    Case("a host after a backslash", value("url", '"https://example.org\\\\@github.com"'), ("bad-value",)),
    Case("a host without letters", value("url", '"https://..../"'), ("bad-value",)),
    Case("an address that runs code", value("url", '"javascript:alert(1)"'), ("bad-value",)),
    Case(
        "an address with a line break",
        value("url", '"https://example.org/\\nx"'),
        ("bad-value", "control-character"),
    ),
    Case(
        "an address with foreign letters in its path",
        value("url", '"https://example.org/ｅ"'),
        ("bad-value",),
    ),
    Case("a title of a formula in a table", value("title", "'=HYPERLINK(\"http://x\",1)'"), (), "table"),
    Case("a budget that is a list", value("budget", "[[1]]"), ("bad-value",)),
    Case(
        "a report and logs",
        edit("format = 1\n", 'format = 1\nreported = "henderson2017"\n', TOML),
        ("foreign-report", "logs-of-a-reported-entry"),
    ),
    Case("a README of 64 KiB in 60,000 lines", put("README.md", b"\n" * 60_000), ()),
    Case("a README of control characters", put("README.md", b"\x07\n" * 30_000), ("readme-character",)),
    Case(
        "a README of combining marks",
        put("README.md", ("o" + "\u0301" * 20_000).encode()),
        ("readme-character",),
    ),
    Case("a README that is not text", put("README.md", b"\xff" * 60_000), ("readme-encoding",)),
    Case("a README of 65,537 bytes", put("README.md", b"x" * 65_537), ("too-large",)),
)

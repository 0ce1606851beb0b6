"""A paragraph of Markdown becomes markup in which nothing but code is markup."""

from __future__ import annotations

import pytest

from gym_extensions.site.text.markdown import inline


@pytest.mark.parametrize(
    ("text", "markup"),
    [
        ("plain", "plain"),
        ("a `b` c", "a <code>b</code> c"),
        ("`<b>` & <i>", "<code>&lt;b&gt;</code> &amp; &lt;i&gt;"),
        ("see [the guide](docs/submit.md)", "see the guide"),
        ("[x](javascript:alert(1))", "x)"),
        ("one ` alone", "one ` alone"),
        ("``", "``"),
        ("level *re-evaluated*, 2 * 3 * 4", "level <em>re-evaluated</em>, 2 * 3 * 4"),
        ("`a*b*c`", "<code>a*b*c</code>"),
    ],
)
def test_code_is_marked_and_everything_else_escaped(text: str, markup: str) -> None:
    assert inline(text) == markup

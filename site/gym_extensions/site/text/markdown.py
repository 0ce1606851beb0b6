"""One paragraph of Markdown as markup: code, emphasis, and links as their text. All else is escaped."""

from __future__ import annotations

import re

from markupsafe import Markup, escape

TAGS = {"`": "<code>{}</code>", "*": "<em>{}</em>"}
"""By the mark around a text."""


def inline(text: str) -> Markup:
    """Markup of a paragraph: ``code`` in backticks, *emphasis*, and of a link the text; no other Markdown."""
    parts = re.split(r"(`[^`]+`|\*\w[^*`]*\w\*)", re.sub(r"\[([^\]]*)\]\([^)\s]*\)", r"\1", text))
    return Markup().join(
        Markup(TAGS[part[0]]).format(part[1:-1]) if index % 2 else escape(part)
        for index, part in enumerate(parts)
    )

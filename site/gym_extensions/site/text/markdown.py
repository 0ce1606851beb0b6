"""One paragraph of Markdown as markup: code, and links as their text. Everything else is escaped."""

from __future__ import annotations

import re

from markupsafe import Markup, escape


def inline(text: str) -> Markup:
    """Markup of a paragraph: ``code`` in backticks; of a link the text; no other Markdown."""
    parts = re.split(r"(`[^`]+`)", re.sub(r"\[([^\]]*)\]\([^)\s]*\)", r"\1", text))
    return Markup().join(
        Markup("<code>{}</code>").format(part[1:-1])
        if len(part) > 2 and part.startswith("`") and part.endswith("`")
        else escape(part)
        for part in parts
    )

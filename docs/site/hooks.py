"""Hooks of mkdocs: pages from the repository's root, and a check that the site is self-contained.

A link to a file that is not part of the site, such as a source file, becomes plain text.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
ROOT_PAGES = {
    "README.md": "index.md",
    "ARCHITECTURE.md": "architecture.md",
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    "SECURITY.md": "report-a-vulnerability.md",
}
"""Pages of the site by their path in the repository; the others are in docs/."""
LINK = re.compile(r"(?P<mark>!?)\[(?P<text>[^\]]*)\]\((?P<target>[^)\s]+)\)")
INDEXED_TWICE = re.compile(r"```.*?```|`[^`\n]*`|\]\[", re.DOTALL)
LOADED = {"audio": "src", "embed": "src", "iframe": "src", "img": "src", "script": "src", "source": "src"}
"""Attributes with the address of what a browser loads, by element; of ``link`` see LOADED_LINKS."""
LOADED_LINKS = {
    "apple-touch-icon",
    "icon",
    "manifest",
    "modulepreload",
    "preconnect",
    "preload",
    "stylesheet",
}
OTHER_HOST = re.compile(r"\s*(?:https?:)?//", re.IGNORECASE)
STYLE_ADDRESS = re.compile(r"(?:url\(|@import)\s*['\"]?\s*((?:https?:)?//[^'\")\s]+)", re.IGNORECASE)


def page_of(path: str) -> str | None:
    """The page of the site that shows a file of the repository, or None."""
    if path in ROOT_PAGES:
        return ROOT_PAGES[path]
    folder, _, rest = path.partition("/")
    return rest if folder == "docs" and not rest.endswith(".py") else None


def with_links(text: str, source: str) -> str:
    """The Markdown of a file of the repository with its links as paths of the site.

    Args:
        text: Markdown.
        source: the file's path in the repository.
    """
    page = page_of(source)
    assert page is not None, source

    def link(match: re.Match[str]) -> str:
        target, hash_mark, heading = match["target"].partition("#")
        if not target or ":" in target:
            return match[0]
        path = posixpath.normpath(posixpath.join(posixpath.dirname(source), target))
        shown = page_of(path)
        if shown is None or not (ROOT / path).is_file():
            index = page_of(f"{path}/README.md") if (ROOT / path / "README.md").is_file() else None
            if index is None:
                return match["text"]
            shown = index
        relative = posixpath.relpath(shown, posixpath.dirname(page) or ".")
        return f"{match['mark']}[{match['text']}]({relative}{hash_mark}{heading})"

    return LINK.sub(link, text)


def with_formulas(text: str) -> str:
    """The Markdown with values such as p[T][j] as text, which would otherwise be links by reference."""
    return INDEXED_TWICE.sub(lambda match: "]\\[" if match[0] == "][" else match[0], text)


def other_hosts(html: str) -> Iterator[str]:
    """Each address on another host that a browser loads for a page. Links for readers are not among them."""
    addresses: list[str] = []

    class Elements(HTMLParser):
        def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
            values = {name: value or "" for name, value in attrs}
            if tag == "link" and LOADED_LINKS & set(values.get("rel", "").split()):
                addresses.append(values.get("href", ""))
            addresses.append(values.get(LOADED.get(tag, ""), ""))
            addresses.extend(values.get("srcset", "").split(","))
            addresses.extend(STYLE_ADDRESS.findall(values.get("style", "")))

    Elements().feed(html)
    styles = re.findall(r"<style[^>]*>(.*?)</style>", html, flags=re.DOTALL)
    yield from (address for address in addresses if OTHER_HOST.match(address))
    yield from (address for style in styles for address in STYLE_ADDRESS.findall(style))


def on_files(files: Any, config: Any) -> Any:
    """Adds the pages of the repository's root."""
    from mkdocs.structure.files import File

    for name, page in ROOT_PAGES.items():
        content = with_links((ROOT / name).read_text(encoding="utf-8"), name)
        files.append(File.generated(config, page, content=content))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Adapts links and formulas of a page."""
    uri = page.file.src_uri
    text = markdown if uri in ROOT_PAGES.values() else with_links(markdown, f"docs/{uri}")
    return with_formulas(text)


def on_post_build(config: Any, **_: Any) -> None:
    """Raises an error if a page or a style sheet of the site loads something from another host.

    The page 404 has links from the root of the host, where the site may not lie; they are made relative.
    """
    from mkdocs.exceptions import PluginError

    site = Path(config.site_dir)
    lost = site / "404.html"
    if lost.is_file():
        lost.write_text(re.sub(r'(href|src)="/(?!/)', r'\1="', lost.read_text("utf-8")), "utf-8")
    loaded = [
        f"{path.relative_to(site)} loads {address}"
        for path in sorted(site.rglob("*"))
        if path.suffix in {".html", ".css"}
        for address in (other_hosts if path.suffix == ".html" else STYLE_ADDRESS.findall)(
            path.read_text(encoding="utf-8")
        )
    ]
    if loaded:
        raise PluginError("The site must not load anything from other hosts: " + "; ".join(loaded))

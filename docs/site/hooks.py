"""Hooks of mkdocs: pages from the repository's root, the board around them, and no request to other hosts.

A link to a file that is not part of the site, such as a source file, becomes text. The documentation is the
folder ``docs`` of the board. If that was built before, pages have its masthead, its search finds the
documentation, too, and no link of either may be dead.
"""

from __future__ import annotations

import json
import posixpath
import re
import shutil
from collections.abc import Iterator
from html import unescape
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

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
            addresses.append(values.get("src", ""))
            addresses.extend(values.get("srcset", "").split(","))
            addresses.extend(STYLE_ADDRESS.findall(values.get("style", "")))

    Elements().feed(html)
    styles = re.findall(r"<style[^>]*>(.*?)</style>", html, flags=re.DOTALL)
    yield from (address for address in addresses if OTHER_HOST.match(address))
    yield from (address for style in styles for address in STYLE_ADDRESS.findall(style))


FOUND = ("*.html", "groups/*.html", "tasks/*.html", "submissions/*.html")
"""The pages of the board that the search finds: all but the tables of all rows and the results by group."""
NO_TEXT = {"nav", "noscript", "pre", "script", "select", "style", "svg", "table"}
HEADINGS = {"h2", "h3", "th"}
MOST_TEXT = 4_000
"""Characters of an entry of the search index."""
PROJECT = ("docs/adr/", "docs/architecture", "docs/changelog", "docs/contributing")
"""Pages on the project itself, which the search lists last."""


class BoardPage(HTMLParser):
    """Title and texts of a page of the board: one per heading or metric with an anchor, the first without.

    Drawings and tables have no text, except the table of all metrics.
    """

    def __init__(self, html: str) -> None:
        super().__init__()
        self.title, self.sections = "", [("", "", "")]
        self._into, self._skipped = "", [""]
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = {name: value or "" for name, value in attrs}
        if tag in NO_TEXT and "formulas" not in values.get("class", ""):
            self._skipped.append(tag)
        elif len(self._skipped) > 1:
            return
        elif tag in {"title", "main"}:
            self._into = tag
        elif values.get("id") and tag in HEADINGS:
            self.sections.append((values["id"], "", ""))
            self._into = "heading"
        elif tag not in {"wbr", "bdi"}:
            self._into = "main" if self._into == "heading" else self._into
            self.handle_data(" ")

    def handle_endtag(self, tag: str) -> None:
        if tag == self._skipped[-1]:
            self._skipped.pop()
        elif len(self._skipped) == 1 and tag in {"title", "main", *HEADINGS}:
            self._into = "main" if tag in HEADINGS else ""

    def handle_data(self, data: str) -> None:
        anchor, heading, text = self.sections[-1]
        if len(self._skipped) > 1:
            return
        if self._into == "title":
            self.title += data
        elif self._into == "heading":
            self.sections[-1] = (anchor, heading + data, text)
        elif self._into == "main":
            self.sections[-1] = (anchor, heading, text + data)


def board_entries(board: Path) -> Iterator[tuple[str, str, str]]:
    """Address, title and text of what the search finds on the board.

    A page of a task, group or submission is one entry; the others have one per heading.
    """
    for file in sorted(file for pattern in FOUND for file in board.glob(pattern)):
        page = BoardPage(file.read_text(encoding="utf-8"))
        sections = page.sections
        if file.parent != board:
            sections = [("", "", " ".join(text for _, _, text in sections))]
        for anchor, heading, text in sections:
            location = f"{file.relative_to(board).as_posix()}{f'#{anchor}' if anchor else ''}"
            yield location, heading.strip() or page.title.removesuffix(" · gym-extensions"), text


def search_index(board: Path, documentation: list[dict[str, str]]) -> str:
    """The script that the board's page Search loads: ``[kind, address, title, text]`` per entry.

    The kind is 0 on the board, 1 in the documentation, and 2 for pages on the project itself. It is a script
    because a page that is opened as a file can read no JSON.
    """
    found = [(0, *entry) for entry in board_entries(board)]
    for entry in documentation:  # the index of mkdocs is HTML
        address, title, text = (
            re.sub(r"<[^>]+>", " ", entry[name]) for name in ("location", "title", "text")
        )
        kind = 2 if f"docs/{address}".startswith(PROJECT) else 1
        found.append((kind, f"docs/{address}", unescape(title), unescape(text)))
    rows = [(*entry, " ".join(text.split())[:MOST_TEXT]) for *entry, text in found]
    return f"searchIndex({json.dumps(rows, separators=(',', ':'), ensure_ascii=False)});\n"


ADDRESS = re.compile(r'<[^>]*?\s(?:href|src)="([^"]*)"')
ID = re.compile(r'<[^>]*?\sid="?([^"\s>]+)')


def dead_links(site: Path) -> list[str]:
    """Links and pictures of every page that lead to no file of the site or to no element of its page."""
    texts = {file: file.read_text(encoding="utf-8") for file in sorted(site.rglob("*.html"))}
    ids = {file: {unescape(found) for found in ID.findall(text)} for file, text in texts.items()}
    dead = []
    for file, text in texts.items():
        for link in dict.fromkeys(ADDRESS.findall(text)):
            address = urlsplit(unescape(link))
            if address.scheme or address.netloc:
                continue
            target = Path(posixpath.normpath(file.parent / unquote(address.path))) if address.path else file
            anchor = unquote(address.fragment)
            lost = anchor and not anchor.startswith("?") and anchor not in ids.get(target, {anchor})
            if lost or not (target in texts or target.is_file()):
                dead.append(f"{file.relative_to(site)} links to {link}")
    return dead


def board_of(config: Any) -> Path | None:
    """The folder of the board that the documentation is a part of; None if it was not built there."""
    board = Path(config.site_dir).parent
    return board if (board / "static" / "masthead.css").is_file() else None


def on_config(config: Any) -> Any:
    """The plugin of the search writes the index, but its script is not loaded: the board has the page."""
    config.extra_javascript = [script for script in config.extra_javascript if script != "search/main.js"]
    return config


def on_env(env: Any, config: Any, **_: Any) -> Any:
    """Gives the templates the masthead of the board; it is empty without a board."""

    def masthead(url: str) -> str:
        from gym_extensions.site.pages import docs_masthead

        return docs_masthead(url, config.repo_url or "") if board_of(config) else ""

    env.globals["masthead"] = masthead
    return env


def on_files(files: Any, config: Any) -> Any:
    """Adds the pages of the repository's root."""
    from mkdocs.structure.files import File

    for name, page in ROOT_PAGES.items():
        content = with_links((ROOT / name).read_text(encoding="utf-8"), name)
        files.append(File.generated(config, page, content=content))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, **_: Any) -> str:
    """Adapts links and formulas of a page, and names the repository where it is cloned."""
    if config.repo_url:
        markdown = markdown.replace("--sparse URL ", f"--sparse {config.repo_url} ")
    uri = page.file.src_uri
    text = markdown if uri in ROOT_PAGES.values() else with_links(markdown, f"docs/{uri}")
    return with_formulas(text)


def on_page_content(html: str, **_: Any) -> str:
    """The page with an empty head of a table as an empty cell: nothing is below it."""
    return re.sub(r"<th([^>]*)></th>", r"<td\1></td>", html)


def on_post_build(config: Any, **_: Any) -> None:
    """Writes the index of the search, and checks all links and that nothing comes from another host.

    The theme's page 404 leads to the root of the host, where the site may not lie; the board has one.

    Raises:
        PluginError: something is loaded from another host, or a link is dead.
    """
    from mkdocs.exceptions import PluginError

    site = Path(config.site_dir)
    board, index = board_of(config), site / "search" / "search_index.json"
    (site / "404.html").unlink(missing_ok=True)
    if board is not None:
        entries = json.loads(index.read_text(encoding="utf-8"))["docs"]
        (board / "search-index.js").write_text(search_index(board, entries), encoding="utf-8")
        shutil.rmtree(index.parent)
        if dead := dead_links(board):
            raise PluginError("Dead links: " + "; ".join(dead))
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

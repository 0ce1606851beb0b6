"""The documentation as a site: links, nothing from other hosts, and the lowest versions."""

import json
import re
import runpy
import tomllib
from pathlib import Path
from types import SimpleNamespace

import pytest

ROOT = Path(__file__).resolve().parents[1]


hooks = SimpleNamespace(**runpy.run_path(str(ROOT / "docs/site/hooks.py")))


@pytest.mark.parametrize(
    ("source", "link", "expected"),
    [
        ("README.md", "[a](docs/submit.md)", "[a](submit.md)"),
        ("README.md", "[a](docs/adr)", "[a](adr/README.md)"),
        ("README.md", "[CITATION.cff](CITATION.cff)", "CITATION.cff"),
        ("docs/submit.md", "[a](rollout-log.md#policies)", "[a](rollout-log.md#policies)"),
        ("docs/submit.md", "[a](../tests/conftest.py)", "a"),
        ("docs/adr/0003-the-log-is-text.md", "[a](../../ARCHITECTURE.md)", "[a](../architecture.md)"),
        ("docs/submit.md", "[a](https://example.org) [b](#x)", "[a](https://example.org) [b](#x)"),
    ],
)
def test_a_link_leads_to_the_page_of_the_site_or_becomes_text(source: str, link: str, expected: str) -> None:
    assert hooks.with_links(link, source) == expected


@pytest.mark.parametrize(
    "html",
    [
        '<script src="https://cdn.example/a.js"></script>',
        '<link rel="stylesheet" href="//cdn.example/a.css">',
        '<img srcset="a.png, https://cdn.example/a.png 2x">',
        '<p style="background: url(https://cdn.example/a.png)">',
        "<style>@import 'https://cdn.example/a.css'</style>",
    ],
)
def test_what_a_page_loads_from_another_host_is_reported(html: str) -> None:
    assert len(list(hooks.other_hosts(html))) == 1


def test_links_for_readers_and_own_files_are_not_reported() -> None:
    html = '<a href="https://example.org">a</a><script src="a.js"></script><link rel="canonical" href="https://a.b">'
    assert list(hooks.other_hosts(html)) == []


def test_a_site_that_loads_from_another_host_is_not_built(tmp_path: Path) -> None:
    exceptions = pytest.importorskip("mkdocs.exceptions")
    (tmp_path / "a.css").write_text("a { background: url('https://cdn.example/a.png') }", encoding="utf-8")
    with pytest.raises(exceptions.PluginError, match=r"a\.css loads https://cdn\.example/a\.png"):
        hooks.on_post_build(SimpleNamespace(site_dir=tmp_path))


def test_the_lowest_versions_are_the_lower_ends_of_the_ranges() -> None:
    required = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["dependencies"]
    lower = dict(re.findall(r"^([\w-]+)(?:\[.*\])?>=([\d.]+)", "\n".join(required), flags=re.MULTILINE))
    text = (ROOT / "constraints-lowest.txt").read_text("utf-8")
    jobs = (ROOT / ".github/workflows/ci.yml").read_text("utf-8").split("\n\n")
    text += "".join(job for job in jobs if "constraints-lowest.txt" in job)
    tested = dict(re.findall(r"([\w-]+)==([\d.]+)", text))
    assert tested.keys() == lower.keys()
    assert [name for name in lower if not f"{tested[name]}.0.0".startswith(f"{lower[name]}.")] == []


TABLE = """Columns as in :func:`other`.

    ======  =======
    column  value
    ======  =======
    run     seed
    ======  =======
"""


def test_docstrings_become_markdown_also_of_a_function_named_like_its_module(tmp_path: Path) -> None:
    griffe = pytest.importorskip("griffe")
    package = tmp_path / "named"
    package.mkdir()
    (package / "__init__.py").write_text('from named.scores import scores\n\n__all__ = ["scores"]\n', "utf-8")
    (package / "scores.py").write_text(f'def scores():\n    """{TABLE}"""\n', "utf-8")
    rewriting = runpy.run_path(str(ROOT / "docs/site/docstrings.py"))["RestructuredText"]()
    loaded = griffe.load("named", search_paths=[tmp_path], extensions=griffe.load_extensions(rewriting))
    assert loaded["scores"].docstring.value == (
        "Columns as in `other`.\n\n| column | value |\n| --- | --- |\n| run | seed |"
    )


BOARD_PAGE = """<title>Hopper &lt;b&gt; · gym-extensions</title>
<header>menu</header><main><h1>Hopper<wbr>Wall</h1><p>hops <svg><title>0.5</title></svg></p>
<table><tr><th id="x">0.1</th></tr></table>
<h2 id="facts">Facts <span>all</span></h2><p>it weighs</p>
<table class="plain formulas"><tr><th id="forgetting">Forgetting</th><td>p[j] &lt; 1</td></tr></table></main>
<footer>end</footer>"""


def test_the_search_finds_the_board_then_the_documentation_then_the_project(tmp_path: Path) -> None:
    (tmp_path / "tasks").mkdir()
    for path in ("metrics.html", "tasks/a.html"):
        (tmp_path / path).write_text(BOARD_PAGE, encoding="utf-8")
    found = [("submit.html#x", "A &amp; b", "<code>p</code> &lt; 1"), ("adr/0001.html", "One", "two")]
    entries = [dict(zip(("location", "title", "text"), entry, strict=True)) for entry in found]
    script = hooks.search_index(tmp_path, entries)
    assert json.loads(script.removeprefix("searchIndex(").removesuffix(");\n")) == [
        [0, "metrics.html", "Hopper <b>", "HopperWall hops"],
        [0, "metrics.html#facts", "Facts", "all it weighs"],
        [0, "metrics.html#forgetting", "Forgetting", "p[j] < 1"],
        [0, "tasks/a.html", "Hopper <b>", "HopperWall hops all it weighs p[j] < 1"],
        [1, "docs/submit.html#x", "A & b", "p < 1"],
        [2, "docs/adr/0001.html", "One", "two"],
    ]


@pytest.mark.parametrize(
    ("link", "dead"),
    [
        ("b/c.html#there", False),
        ("b/c.html#?group=x", False),
        ("#here", False),
        ("https://example.org/nothing", False),
        ("b/c.html#gone", True),
        ("b/README.html", True),
        ("#gone", True),
    ],
)
def test_a_link_to_no_page_or_no_heading_is_dead(tmp_path: Path, link: str, dead: bool) -> None:
    (tmp_path / "b").mkdir()
    (tmp_path / "b/c.html").write_text('<h1 id="there">', encoding="utf-8")
    (tmp_path / "a.html").write_text(f'<p class="x" id=here><a class="y" href="{link}">', encoding="utf-8")
    assert hooks.dead_links(tmp_path) == ([f"a.html links to {link}"] if dead else [])

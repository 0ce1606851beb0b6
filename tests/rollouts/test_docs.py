"""The documentation says what the code does."""

from __future__ import annotations

import re
from pathlib import Path

from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.rollouts import reader, trace_reader  # noqa: F401 - registers the rules of reading
from gym_extensions.rollouts.episodes import CURVE_COLUMNS, EPISODE_COLUMNS
from gym_extensions.rollouts.manifest import SECTIONS
from gym_extensions.rollouts.rules import RULES
from gym_extensions.scoring.replay import segments

DOCS = Path(__file__).parents[2] / "docs"
LOG = (DOCS / "rollout-log.md").read_text(encoding="utf-8")


def test_the_log_page_lists_every_rule_with_its_text() -> None:
    rows = [f"| `{rule.name}` | {rule.text} |" for rule in RULES.values()]
    assert [row for row in rows if row not in LOG] == []


def test_the_log_page_lists_what_replay_tells() -> None:
    sources = (Path(str(module.__file__)).read_text() for module in (trace_reader, segments))
    names = [name for source in sources for name in re.findall(r'Problem\(\s*"([a-z-]+)"', source)]
    assert len(names) == 3
    assert [name for name in names if f"| `{name}` |" not in LOG] == []


def test_the_log_page_has_every_column_and_every_key_of_the_manifest() -> None:
    assert ",".join(EPISODE_COLUMNS) in LOG
    assert ",".join(CURVE_COLUMNS) in LOG
    for section, fields in SECTIONS.items():
        assert not section or f"[{section}]" in LOG
        assert [name for name in fields if f"{name} = " not in LOG] == []
    assert [name for name in BUDGETS if name not in LOG] == []

"""The documentation says what the code does."""

from __future__ import annotations

import re
from pathlib import Path

from gym_extensions.catalog.budgets import BUDGETS
from gym_extensions.rollouts import layout, trace_reader
from gym_extensions.rollouts.episodes import CURVE_COLUMNS, EPISODE_COLUMNS, EVALUATION_COLUMNS
from gym_extensions.rollouts.manifest import SECTIONS
from gym_extensions.rollouts.policies.agreement import TOLERANCE
from gym_extensions.rollouts.policies.keys import KEYS
from gym_extensions.rollouts.rules import RULES
from gym_extensions.rollouts.rules.__main__ import BEGIN, END, rules_table, with_table
from gym_extensions.scoring.replay.faults import HINTS
from gym_extensions.scoring.replay.verify import OTHER_SALT

DOCS = Path(__file__).parents[2] / "docs"
LOG = (DOCS / "rollout-log.md").read_text(encoding="utf-8")


def test_the_table_of_rules_is_current() -> None:
    hint = "Run: python -m gym_extensions.rollouts.rules docs/rollout-log.md"
    assert with_table(LOG) == LOG, hint


def test_the_table_of_rules_replaces_an_older_one() -> None:
    stale = f"# Page\n{BEGIN}\n| an | old table |\n{END}\nText."
    assert with_table(stale) == f"# Page\n{BEGIN}\n{rules_table()}\n{END}\nText."
    assert rules_table().count("\n| `") == len(RULES)


def test_the_log_page_lists_the_problems_of_replay() -> None:
    source = Path(str(trace_reader.__file__)).read_text()
    names = [*re.findall(r'Problem\(\s*"([a-z-]+)"', source), *HINTS]
    names.append(OTHER_SALT)
    assert len(names) == 6
    assert [name for name in names if f"| `{name}` |" not in LOG] == []


def test_the_log_page_states_the_limits() -> None:
    section = LOG[LOG.index("## Limits") : LOG.index("## The rules")]
    for size in (layout.MAX_FILE_BYTES[".toml"] // 2**10, f"{layout.MAX_FILES:,}", layout.MAX_ARRAYS):
        assert f" {size} " in section
    mebibytes = (
        *(*layout.MAX_FILE_BYTES.values(), layout.MAX_UNPACKED_BYTES),
        *(layout.MAX_POLICY_BYTES, layout.MAX_UNPACKED_POLICY_BYTES),
    )
    assert [size for size in mebibytes if size >= 2**20 and f" {size // 2**20} MiB" not in section] == []
    assert f" {layout.MAX_SUBMISSION_BYTES // 2**30} GiB" in section


def test_the_log_page_lists_the_arrays_of_a_policy_and_their_choices() -> None:
    section = LOG[LOG.index("## Policies") :]
    for name, key in KEYS.items():
        row = re.search(rf"^\| `{name}(_<i>)?`.*$", section, re.MULTILINE)
        assert row is not None, name
        assert [choice for choice in key.choices if f"`{choice}`" not in row[0]] == []
        assert ("T" in row[0].split("|")[3]) == key.has_tasks, name
    assert f"{TOLERANCE:g} half widths" in section


def test_the_log_page_has_every_column_and_every_key_of_the_manifest() -> None:
    assert ",".join(EPISODE_COLUMNS) in LOG
    assert ",".join(CURVE_COLUMNS) in LOG
    assert ",".join(EVALUATION_COLUMNS) in LOG
    assert [section for section in SECTIONS if section and f"[{section}]" not in LOG] == []
    for fields in SECTIONS.values():
        assert [name for name in fields if f"{name} = " not in LOG] == []
    assert [name for name in BUDGETS if name not in LOG] == []

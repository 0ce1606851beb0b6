"""One of each addition is made in a copy of the repository.

They work, edit the files that CONTRIBUTING.md lists, and leave the tests of the packages that they touch as
they are. A process loads the packages for seconds, so that one tests all of them.
"""

import filecmp
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
ROOTS = ("envs", "scoring", "baselines", "site")
OTHERS = ("docs", "tests", "tools", "examples")
"""Other folders that the tests of packages read."""
TABLE = re.findall(
    r"^\| \*\*(.+?)\*\* \| (.+?) \|", (ROOT / "CONTRIBUTING.md").read_text("utf-8"), flags=re.MULTILINE
)
FILES = {addition: re.findall(r"`([^`]+)`", files) for addition, files in TABLE}
"""The files of each addition in CONTRIBUTING.md, with NAME for the name of the addition."""

ROW = 'MONOPOD = replace(HOPPER, name="Monopod", camera=None)\n'
TEXTS = '[Monopod]\nsummary = "S."\nreward = "R."\nstart = "T."\nend = "E."\nsource = "Q."\n\n'
IMPLEMENTATION = '    "Monopod": Implementation(planar.PlanarRules, hopper_v5.DEFAULT_CAMERA_CONFIG),\n'
USE_BODY = """
import numpy as np
from gym_extensions.catalog.tasks import TASKS
from gym_extensions.envs import Gravity, MotorNoise, RangeSensor, Wall, customize, make, make_vec

def test_added():
    busy = customize(TASKS["gym_extensions/Monopod-v0"], [Gravity(0.8), MotorNoise(), RangeSensor(), Wall()])
    assert type(make_vec(busy, 2)).__name__ == type(make_vec("Hopper", 2)).__name__
    np.testing.assert_array_equal(make_vec(busy, 1).reset(seed=[3])[0][0], make(busy).reset(seed=3)[0])
"""

VARIATION = '''

@dataclass(frozen=True)
class WeakMotors(Variation):
    """Multiplies every command by a factor."""

    factor: float = 0.5


@dataclass(frozen=True)
class MovingGoal'''
EFFECT = """
class WeakMotorsEffect(Effect):
    kind = variations.WeakMotors

    def __init__(self, fields, templates):
        self._factor = variation_of(templates[0].task, variations.WeakMotors).factor

    def control(self, ctrl, steps):
        return self._factor * ctrl


EFFECTS: """
USE_VARIATION = """
import numpy as np
from gym_extensions.envs import WeakMotors, customize, make, make_vec

def test_added():
    task = customize("Hopper", [WeakMotors()])
    vector, single, full = make_vec(task, 1), make(task), make("Hopper")
    vector.reset(seed=[3]); single.reset(seed=3); full.reset(seed=3)
    action = np.full(3, 0.5, np.float32)
    weak = single.step(action)[0]
    np.testing.assert_array_equal(vector.step(action[None])[0][0], weak)
    assert not np.array_equal(full.step(action)[0], weak)
"""


METRIC = """\
    Metric(
        "best_task",
        "Best task",
        "max over j of p[T][j]",
        lambda run: sorted(((j, run.p(run.T, j)) for j in run.scored), key=lambda term: term[1])[-1:],
        HIGHER,
        columns=("sequential",),
        shown=("boards", "screen"),
    ),
"""
KIT = '"forgetting": [0.5], "best_task": [1],'
USE_METRIC = """
from gym_extensions.scoring import score_folder
from tools.docs import tables

def test_added(make_submission):
    assert "| `best_task` Best task | max over j of p[T][j] |" in tables()["metrics sequential"]
    score = score_folder(make_submission()).groups["hopper-gravity-v0"]["sequential"]
    assert score.metrics["best_task"].mean >= score.metrics["final_performance"].mean
"""
AGENT = """
import numpy as np
from gym_extensions.baselines import Card


class Ones:
    def __init__(self, observation_space, action_space, seed):
        self.shape = action_space.shape

    def act(self, observations):
        return np.ones((len(observations), *self.shape), np.float32)

    def learn(self, env, steps):
        pass

    def card(self):
        return Card("ones", evaluation="deterministic")

    def save(self, path):
        path.touch()

    def load(self, path):
        pass


make = Ones
"""
USE_AGENT = """
from gym_extensions.baselines import algorithms, train

def test_added(tmp_path):
    assert "ones" in algorithms.names()
    (log,) = train("ones", "pusher", "single", "smoke", 0, out=tmp_path / "ones")
    assert len(log.read_text().splitlines()) == 1 + 2 * 20
"""
PAGE = """
    Page(
        "Hello",
        "hello.html",
        lambda site, render: [("hello.html", render("hello.html", "hello.html"))],
    ),
)
"""
TEMPLATE = """{% extends "base.html" %}
{% block title %}Hello{% endblock %}
{% block description %}A page that greets.{% endblock %}
{% block main %}<h1>Hello</h1><p>Hello page</p>{% endblock %}
"""
USE_PAGE = """
from gym_extensions.site.cli import main
from .conftest import write_submission

def test_added(tmp_path):
    write_submission(tmp_path / "submissions")
    main([str(tmp_path / "submissions"), "--out", str(tmp_path / "_site")])
    page = (tmp_path / "_site" / "hello.html").read_text()
    assert "<p>Hello page</p>" in page.partition("<main")[2]
"""

SECTION = """\
class Compute(msgspec.Struct, frozen=True):
    hours: Count


class Manifest("""
USE_SECTION = """
from gym_extensions.submissions.reader import read
from .conftest import MANIFEST

def test_added(make_submission):
    manifest = MANIFEST + "[compute]\\nhours = 3\\n"
    assert read(make_submission(manifest=manifest)).manifest.compute.hours == 3
    for key, value, rule in (("hour", 3, "unknown-key"), ("hours", -3, "bad-value")):
        wrong = manifest.replace("hours = 3", f"{key} = {value}")
        assert rule in {problem.rule for problem in read(make_submission(manifest=wrong)).problems}
"""
RULE = """\
@rule("manifest")
def loud_title(folder: Folder, tables: Tables) -> Iterator[Finding]:
    '''The title has no exclamation mark.'''
    if "!" in str(tables.get("title")):
        yield Finding(where_of("", "title"), "The title is loud.", "Remove the mark.")


@rule("readme")"""
USE_RULE = """
from gym_extensions.submissions.reader import read
from tools.docs import tables
from .conftest import MANIFEST

def test_added(make_submission):
    loud = make_submission(manifest=MANIFEST.replace("A submission", "A submission!"))
    assert [problem.rule for problem in read(loud).problems] == ["loud-title"]
    assert "| `loud-title` | The title has no exclamation mark. |" in tables()["rules"]
"""

USE_VERSION = """
from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.tasks import task, versions
from gym_extensions.envs import make

def test_added():
    old, new = task("HopperGravityHalf"), task("HopperGravityHalf-v1")
    assert (old.version, new.version, new.variations[0].factor) == (0, 1, 0.4)
    assert old in GROUPS["hopper-gravity"].tasks and new not in GROUPS["hopper-gravity"].tasks
    assert versions(new)[1] == "less gravity"
    ids = old.id, new.id, new.bare_name
    assert len({make(name).unwrapped.model.opt.gravity[2] for name in ids}) == 2
"""
USE_TASK = """
from gym_extensions.catalog.fingerprints import published
from gym_extensions.catalog.tasks import task
from gym_extensions.envs import fingerprinting, make

def test_added():
    heavy = task("HopperGravityOneAndThreeQuarters")
    assert make(heavy.id).unwrapped.model.opt.gravity[2] == -17.1675
    assert len(published(heavy.id)) == 16
    assert fingerprinting.check([heavy]) == []
"""


@pytest.fixture
def copy() -> Iterator[Path]:
    """A copy of the repository without submissions; its source roots come first on the path of ``run``.

    Everybody can read it, because the tests of the box run programs as an ordinary user.
    """
    with tempfile.TemporaryDirectory() as parent:
        Path(parent).chmod(0o755)
        copied = Path(parent) / "copy"
        for folder in (*ROOTS, *OTHERS):
            shutil.copytree(ROOT / folder, copied / folder)
        for path in (each for each in ROOT.iterdir() if each.is_file()):
            shutil.copy(path, copied)
        yield copied


def run(copy: Path, *arguments: str) -> None:
    """Runs Python in the copy; fails with what it prints."""
    paths = os.pathsep.join(map(str, [*(copy / root for root in ROOTS), copy]))
    own = os.environ | {"PYTHONPATH": paths}
    command = [sys.executable, *arguments]
    process = subprocess.run(command, cwd=copy, env=own, capture_output=True, text=True, check=False)
    assert process.returncode == 0, process.stdout + process.stderr


def changed(copy: Path) -> list[str]:
    """The source files of the copy that are new or different, without the root and the package's folder."""
    files = [path.relative_to(copy) for root in ROOTS for path in (copy / root).rglob("*") if path.is_file()]
    return sorted(
        "/".join(path.parts[2:])
        for path in files
        if "__pycache__" not in path.parts
        and not ((ROOT / path).exists() and filecmp.cmp(ROOT / path, copy / path, shallow=False))
    )


PYTEST = ("-m", "pytest", "-q", "-p", "no:cacheprovider")
FINGERPRINTS = ("-m", "tools.environments.fingerprints")
WRITE_TABLES = """
from tools import ROOT, docs
for page in (ROOT / "docs").glob("*.md"):
    text = page.read_text(encoding="utf-8")
    page.write_text(docs.updated(text), encoding="utf-8")
"""
"""The tables of ``make docs``. Its other pages take longer, and some need submissions."""

LAST = '    tasks += [_task("", body) for body in STANDING'
HEAVY = '    tasks.append(_task("GravityOneAndThreeQuarters", "Hopper", variations.Gravity(1.75)))\n'
LIGHTER = '    tasks.append(replace(_task("GravityHalf", "Hopper", variations.Gravity(0.4)), version=1))\n'
CHANGES = 'str] = {"gym_extensions/HopperGravityHalf-v1": "less gravity"}'
CATALOG, ENVS = "envs/gym_extensions/catalog", "envs/gym_extensions/envs"
METRICS, SITE = "scoring/gym_extensions/metrics", "site/gym_extensions/site"
SUBMISSIONS = "scoring/gym_extensions/submissions"
Edit = tuple[str, str, str]
"""A file; a text, whose last occurrence is replaced, or nothing for a new file; and the new text."""
ADDITIONS: dict[str, tuple[list[Edit], str]] = {
    "Task": ([(f"{CATALOG}/tasks.py", LAST, HEAVY + LAST)], USE_TASK),
    "Base body": (
        [
            (f"{CATALOG}/bodies.py", "ROWS = (", f"{ROW}ROWS = ("),
            (f"{CATALOG}/bodies.py", "NAVIGATION)", "NAVIGATION, MONOPOD)"),
            (f"{CATALOG}/prose.toml", "[Hopper]", f"{TEXTS}[Hopper]"),
            (f"{ENVS}/mujoco/env.py", '}\n"""One row', IMPLEMENTATION + '}\n"""One row'),
        ],
        USE_BODY,
    ),
    "Variation": (
        [
            (f"{CATALOG}/variations.py", "\n\n@dataclass(frozen=True)\nclass MovingGoal", VARIATION),
            (f"{CATALOG}/variations.py", '    "Wall",\n]', '    "Wall",\n    "WeakMotors",\n]'),
            (f"{ENVS}/effects.py", "EFFECTS: ", EFFECT),
            (f"{ENVS}/effects.py", "TrackingGoalEffect),", "TrackingGoalEffect, WeakMotorsEffect),"),
        ],
        USE_VARIATION,
    ),
    "Metric": (
        [
            (f"{METRICS}/formulas.py", ')\n"""Every metric.', METRIC + ')\n"""Every metric.'),
            (f"{METRICS}/conformance/sequential.json", '"forgetting": [0.5],', KIT),
        ],
        USE_METRIC,
    ),
    "Reference agent": ([("baselines/gym_extensions/baselines/algorithms/ones.py", "", AGENT)], USE_AGENT),
    "Page": (
        [(f"{SITE}/pages/__init__.py", "\n)\n", PAGE), (f"{SITE}/templates/hello.html", "", TEMPLATE)],
        USE_PAGE,
    ),
    "Key of a submission": (
        [
            (f"{SUBMISSIONS}/manifest.py", "class Manifest(", SECTION),
            (f"{SUBMISSIONS}/manifest.py", " = {}\n", " = {}\n    compute: Compute | None = None\n"),
        ],
        USE_SECTION,
    ),
    "Rule": ([(f"{SUBMISSIONS}/rules/manifest.py", '@rule("readme")', RULE)], USE_RULE),
    "Version of a task": (
        [(f"{CATALOG}/tasks.py", LAST, LIGHTER + LAST), (f"{CATALOG}/tasks.py", "str] = {}", CHANGES)],
        USE_VERSION,
    ),
}
"""By name in CONTRIBUTING.md: what is added, and a test that uses it."""
ADDED = {"Reference agent": "ones", "Page": "hello", "Rule": "manifest"}
"""What NAME is."""


def add(name: str, copy: Path) -> None:
    for file, old, new in ADDITIONS[name][0]:
        path = copy / file
        before, match, after = path.read_text("utf-8").rpartition(old) if old else ("", old, "")
        assert match == old
        path.write_text(before + new + after, encoding="utf-8")


TESTS = (
    *("tests/catalog", "tests/metrics", "tests/tools/test_docs.py", "tests/baselines/test_public_api.py"),
    *("tests/site/test_documentation.py", "tests/site/test_markup.py"),
    "tests/baselines/algorithms/test_reference_agents.py",
    "tests/results/test_scores.py::test_every_metric_of_the_scorecard_is_a_row",
    "tests/test_public_api.py::test_a_package_exports_these_names",
)
"""Those that would notice an addition first."""


def test_additions_edit_the_files_of_the_table_and_work_together(copy: Path) -> None:
    assert FILES.keys() < ADDITIONS.keys()
    before: list[str] = []
    for index, (name, (_, use)) in enumerate(ADDITIONS.items()):
        add(name, copy)
        (copy / "tests" / f"test_added_{index}.py").write_text(use, encoding="utf-8")
        if name in FILES:
            listed = sorted(file.replace("NAME", ADDED.get(name, "")) for file in FILES[name])
            assert sorted({*changed(copy)} - {*before}) == listed
        before = changed(copy)
    run(copy, *FINGERPRINTS)
    run(copy, "-c", WRITE_TABLES)
    run(copy, *PYTEST, *(f"tests/test_added_{index}.py" for index in range(len(ADDITIONS))), *TESTS)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "tests"),
    [
        ("Task", ("catalog", "envs", "tools", "site")),
        ("Variation", ("catalog", "envs", "tools", "site/play")),
        ("Metric", ("metrics", "scoring", "results", "export", "site", "tools")),
        ("Reference agent", ("baselines", "examples")),
        ("Page", ("site",)),
    ],
)
def test_all_tests_of_packages_pass_after_an_addition(copy: Path, name: str, tests: tuple[str, ...]) -> None:
    """``make docs`` is run as CONTRIBUTING.md says, with the committed submissions."""
    (copy / "submissions").symlink_to(ROOT / "submissions")
    add(name, copy)
    run(copy, *FINGERPRINTS)
    run(copy, "-m", "tools.docs")
    run(copy, *PYTEST, *(f"tests/{folder}" for folder in tests))

"""One of each addition is made in a copy of the packages: it works, and edits the files that are listed."""

from __future__ import annotations

import filecmp
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from .conftest import write_submission

ROOT = Path(__file__).resolve().parents[1]
ROOTS = ("envs", "scoring", "baselines", "site")
TABLE = re.findall(
    r"^\| \*\*(.+?)\*\* \| (.+?) \|", (ROOT / "CONTRIBUTING.md").read_text("utf-8"), flags=re.MULTILINE
)
FILES = {addition: re.findall(r"`([^`]+)`", files) for addition, files in TABLE}
"""The files of each addition in CONTRIBUTING.md, with NAME for the name of the addition."""

ROW = """
    Body(
        name="Monopod",
        family="planar",
        asset="hopper.xml",
        model_name="hopper",
        rewards=RewardBounds(-20.0, 20.0),
        beams="pitch",
        velocity_limit=10.0,
        wall_width=0.8,
    ),
)
"""
TEXTS = '[Monopod]\nsummary = "S."\nreward = "R."\nstart = "T."\nend = "E."\nsource = "Q."\n\n'
SUBMISSION = '    "Monopod": Implementation(planar.HopperRules, 4, hopper_v5.DEFAULT_CAMERA_CONFIG),\n'
USE_BODY = """
import numpy as np
from gym_extensions.catalog.tasks import TASKS
from gym_extensions.envs import Gravity, MotorNoise, RangeSensor, Wall, customize, make, make_vec
task = TASKS["gym_extensions/Monopod-v0"]
busy = customize(task, [Gravity(0.8), MotorNoise(), RangeSensor(), Wall()])
assert type(make_vec(busy, 2)).__name__ == type(make_vec("Hopper", 2)).__name__
np.testing.assert_array_equal(make_vec(busy, 1).reset(seed=[3])[0][0], make(busy).reset(seed=3)[0])
"""

VARIATION = '''

@dataclass(frozen=True)
class WeakMotors(Variation):
    """Multiplies every command by a factor."""

    factor: float = 0.5
'''
EFFECT = """
class WeakMotorsEffect(Effect):
    of = variations.WeakMotors

    def __init__(self, fields, templates):
        self._factor = variation_of(templates[0].task, variations.WeakMotors).factor

    def control(self, ctrl, steps):
        return self._factor * ctrl


EFFECTS: """
USE_VARIATION = """
import numpy as np
from gym_extensions.catalog.variations import WeakMotors
from gym_extensions.envs import customize, make, make_vec
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
USE_METRIC = """
import json, sys
from gym_extensions.scoring.cli import main
from tools.docs import tables
assert "| `best_task` Best task | max over j of p[T][j] |" in tables()["metrics sequential"]
main([sys.argv[1], "--json"])
"""
BASELINE = """
import numpy as np


class Ones:
    def __init__(self, observation_space, action_space, seed):
        self.shape = action_space.shape

    def act(self, observations):
        return np.ones((len(observations), *self.shape), np.float32)

    def learn(self, env, steps):
        pass


make = Ones
"""
USE_BASELINE = """
import sys
from gym_extensions.baselines import algorithms, train
assert "ones" in algorithms.names()
(log,) = train("ones", "pusher", "single", "smoke", 0, out=sys.argv[1])
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
TEMPLATE = '{% extends "base.html" %}{% block main %}<p>Hello page</p>{% endblock %}'
USE_PAGE = """
import sys
from pathlib import Path
from gym_extensions.site.cli import main
main([sys.argv[1], "--out", sys.argv[2]])
page = (Path(sys.argv[2]) / "hello.html").read_text()
assert "<p>Hello page</p>" in page.partition("<main")[2]
"""


USE_VERSION = """
from gym_extensions.catalog.groups import GROUPS
from gym_extensions.catalog.tasks import task, versions
from gym_extensions.envs import make
old, new = task("HopperGravityHalf"), task("HopperGravityHalf-v1")
assert (old.version, new.version, new.variations[0].factor) == (0, 1, 0.4)
assert old in GROUPS["hopper-gravity"].tasks and new not in GROUPS["hopper-gravity"].tasks
assert versions(new)[1] == "less gravity"
assert make(new.id).unwrapped.model.opt.gravity[2] != make(old.id).unwrapped.model.opt.gravity[2]
"""


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """A copy of the four source roots, which comes first on the path of ``run``; it keeps their bytecode."""
    for root in ROOTS:
        shutil.copytree(ROOT / root, tmp_path / root, ignore=shutil.ignore_patterns("data"))
    return tmp_path


def run(copy: Path, code: str, *arguments: str | Path) -> str:
    """Runs the code with the copied packages and returns its output; fails with its error output."""
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join([*(str(copy / root) for root in ROOTS), str(ROOT)])
    }
    process = subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == 0, process.stderr
    return process.stdout


def edit(path: Path, old: str, new: str) -> None:
    """Replaces the last occurrence of a text in a file."""
    before, match, after = path.read_text(encoding="utf-8").rpartition(old)
    assert match
    path.write_text(before + new + after, encoding="utf-8")


def changed(copy: Path) -> list[str]:
    """The files of the copy that are new or different, without the root and the package's folder."""
    files = [path.relative_to(copy) for root in ROOTS for path in (copy / root).rglob("*") if path.is_file()]
    return sorted(
        "/".join(path.parts[2:])
        for path in files
        if "__pycache__" not in path.parts
        and not ((ROOT / path).exists() and filecmp.cmp(ROOT / path, copy / path, shallow=False))
    )


def listed(addition: str, name: str = "") -> list[str]:
    """The files that CONTRIBUTING.md lists for an addition of that name."""
    return sorted(file.replace("NAME", name) for file in FILES[addition])


def test_a_version_of_a_task_leaves_the_old_one_and_its_groups(copy: Path) -> None:
    tasks = copy / "envs" / "gym_extensions" / "catalog" / "tasks.py"
    version = '    tasks.append(replace(_task("GravityHalf", "Hopper", Gravity(0.4)), version=1))\n'
    edit(
        tasks,
        '    tasks += [_task("", body) for body in STANDING',
        version + '    tasks += [_task("", body) for body in STANDING',
    )
    edit(tasks, "str] = {}", 'str] = {"gym_extensions/HopperGravityHalf-v1": "less gravity"}')
    run(copy, USE_VERSION)


def test_a_base_body_is_data_and_a_submission_in_the_registry_of_classes(copy: Path) -> None:
    catalog, envs = (copy / "envs" / "gym_extensions" / name for name in ("catalog", "envs"))
    edit(catalog / "bodies.py", "\n)\n\n\nBODIES", f"{ROW}\n\nBODIES")
    edit(catalog / "prose.toml", "[Hopper]", f"{TEXTS}[Hopper]")
    edit(envs / "mujoco" / "env.py", '    "Pusher"', SUBMISSION + '    "Pusher"')
    run(copy, USE_BODY)
    assert changed(copy) == listed("Base body")


def test_a_runtime_variation_is_its_values_and_its_effect(copy: Path) -> None:
    catalog, envs = (copy / "envs" / "gym_extensions" / name for name in ("catalog", "envs"))
    edit(
        catalog / "variations.py",
        "\n\n@dataclass(frozen=True)\nclass MovingGoal",
        f"{VARIATION}\n\n@dataclass(frozen=True)\nclass MovingGoal",
    )
    effects = envs / "effects.py"
    edit(effects, "EFFECTS: ", EFFECT)
    edit(effects, "TrackingGoalEffect),", "TrackingGoalEffect, WeakMotorsEffect),")
    run(copy, USE_VARIATION)
    assert changed(copy) == listed("Run-time variation")


def test_a_metric_is_a_row_and_its_worked_example(copy: Path, make_submission: Callable[..., Path]) -> None:
    metrics = copy / "scoring" / "gym_extensions" / "metrics"
    edit(metrics / "formulas.py", ')\n"""Every metric.', METRIC + ')\n"""Every metric.')
    kit = metrics / "conformance" / "sequential.json"
    edit(kit, '"forgetting": [0.5],', '"forgetting": [0.5], "best_task": [1],')
    groups = json.loads(run(copy, USE_METRIC, make_submission()))["submissions"][0]["groups"]
    score = groups["hopper-gravity-v0"]["sequential"]
    assert score["metrics"]["best_task"]["mean"] >= score["metrics"]["final_performance"]["mean"]
    run(copy, "import pytest, sys; sys.exit(pytest.main(['-q', sys.argv[1]]))", ROOT / "tests" / "metrics")
    assert changed(copy) == listed("Metric")


def test_a_baseline_is_one_module(copy: Path, tmp_path: Path) -> None:
    algorithms = copy / "baselines" / "gym_extensions" / "baselines" / "algorithms"
    (algorithms / "ones.py").write_text(BASELINE, encoding="utf-8")
    run(copy, USE_BASELINE, tmp_path / "ones")
    assert changed(copy) == listed("Reference agent", "ones")


def test_a_page_is_a_function_and_its_template(copy: Path, tmp_path: Path) -> None:
    site = copy / "site" / "gym_extensions" / "site"
    edit(site / "pages" / "__init__.py", "\n)\n", PAGE)
    (site / "templates" / "hello.html").write_text(TEMPLATE, encoding="utf-8")
    write_submission(tmp_path / "submissions")
    run(copy, USE_PAGE, tmp_path / "submissions", tmp_path / "_site")
    assert changed(copy) == listed("Page", "hello")

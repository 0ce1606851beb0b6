"""A custom group from training to its board."""

import json
import re
import shutil
from pathlib import Path
from typing import Any

import msgspec
import pytest
from gymnasium.spaces import Box

from gym_extensions import results
from gym_extensions.__main__ import main
from gym_extensions.baselines import Factory, references as measuring, train
from gym_extensions.baselines.algorithms.floors import Random
from gym_extensions.catalog.groups import with_custom
from gym_extensions.envs import customize, load_group, make
from gym_extensions.envs.fingerprinting import fingerprint_of
from gym_extensions.envs.mujoco.model import compile_model
from gym_extensions.references import CURRENT, read_references
from gym_extensions.scoring import cli as score_cli
from gym_extensions.scoring.pipeline import make_scorer
from gym_extensions.submissions.reader import read
from gym_extensions.submissions.run import read_run, write_run

from .baselines.conftest import make_quick

LIGHT = """
name = "hopper-light"

[[tasks]]
task = "HopperGravityOneAndHalf"

[[tasks]]
task = "Hopper"
variations = [{kind = "Gravity", factor = 0.3}]
max_steps = 20
"""
DOCUMENT = "hopper-light/sequential/run0.json"
PAGE = (Path(__file__).parents[1] / "docs" / "custom-groups.md").read_text(encoding="utf-8")


class OtherRandom(Random):
    """Random actions of another generator."""

    def __init__(self, observation_space: Box, action_space: Box, seed: int) -> None:
        super().__init__(observation_space, action_space, seed + 1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the group's TOML file, its references, and two submissions."""
    root = tmp_path_factory.mktemp("custom")
    group = root / "light.toml"
    group.write_text(LIGHT, encoding="utf-8")
    agents: dict[str, str | Factory] = {"random": "random", "other": OtherRandom}
    for name, agent in agents.items():
        protocols = ["sequential", "single"] if name == "random" else ["sequential"]
        train(agent, group, protocols, "smoke", [0, 1], out=root / name)
    with pytest.MonkeyPatch.context() as patch:
        make_quick(patch, 20)
        options = ["--groups", str(group), "--budget", "smoke", "--runs", "1000", "--agent", "random"]
        assert measuring.main([*options, "--out", str(root / "light-references.json")]) == 0
    return root


@pytest.fixture
def options(folder: Path) -> list[str]:
    return ["--groups", str(folder / "light.toml"), "--references", str(folder / "light-references.json")]


def test_without_the_file_the_group_is_unknown(folder: Path) -> None:
    (problem,) = read(folder / "random").problems
    assert (problem.rule, problem.where) == ("unknown-group", "hopper-light")
    assert "--groups" in problem.hint


def test_the_scorecard_marks_the_group_as_custom(
    folder: Path, options: list[str], capsysbinary: pytest.CaptureFixture[bytes]
) -> None:
    assert score_cli.main([str(folder / "random"), "--json", *options]) == 0
    document = json.loads(capsysbinary.readouterr().out)
    score = document["submissions"][0]["groups"]["hopper-light-v0"]["sequential"]
    assert (score["published"], score["runs"]) == (False, [0, 1])
    assert document["references"]["version"] == f"{CURRENT} + light-references"


def test_a_group_can_be_scored_by_its_name_or_its_id(tmp_path: Path) -> None:
    file = tmp_path / "light.toml"
    file.write_text(f"version = 1\n{LIGHT}", encoding="utf-8")
    for name in ("hopper-light", "hopper-light-v1"):
        assert make_scorer([file], only=[name]).only == ("hopper-light",)
    assert "hopper-light" in make_scorer(str(file)).groups, "one file needs no list"


def test_pages_show_the_group(folder: Path, options: list[str], tmp_path: Path) -> None:
    assert main(["site", str(folder / "random"), *options, "--out", str(tmp_path / "pages")]) == 0
    assert "hopper-light" in (tmp_path / "pages/submissions/random.html").read_text("utf-8")
    references = (tmp_path / "pages/references.html").read_text("utf-8")
    assert 'href="tasks/hopper-v0.html"' in references, "the published ones stay"


def test_the_references_hold_the_custom_task_alone(folder: Path) -> None:
    own = read_references(folder / "light-references.json")
    light = load_group(folder / "light.toml")
    assert tuple(own.tasks) == light.task_ids[1:], "the first is published"
    row = json.loads((folder / "light-references.json").read_text())["tasks"][light.task_ids[1]]
    assert row["floor"]["fingerprint"] == fingerprint_of(light.tasks[1])


def test_runs_with_two_fingerprints_of_a_custom_task_are_a_problem(folder: Path, tmp_path: Path) -> None:
    light = load_group(folder / "light.toml")
    shutil.copytree(folder / "random", tmp_path / "copy")
    document = read_run(tmp_path / "copy" / DOCUMENT)
    fingerprints = document.fingerprints | {light.task_ids[1]: "0" * 16}
    write_run(tmp_path / "copy" / DOCUMENT, msgspec.structs.replace(document, fingerprints=fingerprints))
    rules = {problem.rule for problem in read(tmp_path / "copy", with_custom([light])).problems}
    assert rules == {"foreign-fingerprint"}


def test_the_page_defines_one_group_in_two_ways(tmp_path: Path) -> None:
    text, _ = re.findall(r"```toml\n(.*?)```", PAGE, flags=re.DOTALL)
    (tmp_path / "light.toml").write_text(text, encoding="utf-8")
    definition, own, _ = re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)
    names: dict[str, Any] = {}
    exec(definition, names)
    assert names["group"] == load_group(tmp_path / "light.toml")
    exec(own, names)
    plain, slippery = map(compile_model, (customize("Hopper"), names["slippery"]))
    assert slippery.geom_friction[:, 0].tolist() == (0.5 * plain.geom_friction[:, 0]).tolist()


def test_the_python_of_the_page_trains_and_scores(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With finished runs of the agent ``random``, so that nothing is trained again."""
    *_, code = re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)
    quick = {'"trpo"': '"random"', '"mine"': '"random"', '"100k"': '"smoke"', "range(5)": "range(2)"}
    for old, new in quick.items():
        assert old in code
        code = code.replace(old, new)
    monkeypatch.chdir(folder)
    names: dict[str, Any] = {"group": load_group("light.toml")}
    exec(code, names)
    assert set(names["frame"]["group"]) == {"hopper-light-v0"}
    assert sorted(names["board"]["name"]) == ["other", "random", "random", "zero"]


def test_the_page_names_a_module_that_registers_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _, text = re.findall(r"```toml\n(.*?)```", PAGE, flags=re.DOTALL)
    (tmp_path / "pendulum.toml").write_text(text)
    (tmp_path / "my_tasks.py").write_text(
        "import gymnasium\ngymnasium.register('mine/HeavyPendulum-v0', kwargs={'g': 12.0},\n"
        "    entry_point='gymnasium.envs.classic_control:PendulumEnv', max_episode_steps=50)\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    _, heavy = load_group(tmp_path / "pendulum.toml").tasks
    assert heavy.id == "mine/HeavyPendulum-v0.steps-200"
    assert make(heavy).unwrapped.g == 12.0  # type: ignore[attr-defined]


def test_a_group_of_any_gymnasium_environment_is_trained_and_scored_with_its_own_references(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, out, known = tmp_path / "own.toml", tmp_path / "mine", tmp_path / "references.json"
    file.write_text('name = "pendulum"\n[[tasks]]\ntask = "Pendulum-v1"\nmax_steps = 20\n')
    train("random", file, ["sequential", "single"], "smoke", [0, 1], out=out)
    make_quick(monkeypatch, 20)
    options = ["--groups", str(file), "--budget", "smoke", "--runs", "1000", "--agent", "random"]
    assert measuring.main([*options, "--out", str(known)]) == 0
    frame = results.metrics(out, groups=[file], references=known)
    assert set(frame["group"]) == {"pendulum-v0"}
    cache = ["--seeds", "0" * 40, "--cache", str(tmp_path / "cache")]
    assert main(["verify", str(out), "--groups", str(file), *cache]) == 0
    assert list(tmp_path.glob("cache/verify/*")) == [], "no version tells what the environment's code does"
    scored = results.scores(out, load_group(file), groups=[file], references=known)
    assert set(scored["task"]) == {"Pendulum-v1.steps-20"}
    assert scored["return"].lt(0).all()

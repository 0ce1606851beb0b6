"""A user's own group, as a Python object or a TOML file."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.catalog.groups import TaskGroup, group, load_group, resolve_group
from gym_extensions.catalog.tasks import customize, task
from gym_extensions.catalog.variations import Gravity

from ..conftest import refused

LIGHT = """
name = "hopper-light"

[[tasks]]
task = "Hopper"

[[tasks]]
task = "Hopper"
variations = [{kind = "Gravity", factor = 0.3}]
max_steps = 500
"""


EXTRA = 'variations = [{kind = "Gravity", factor = 1.0}]\nmax_steps = 500'


def write(folder: Path, text: str) -> Path:
    path = folder / "my.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_toml_file_gives_the_group_that_the_same_python_objects_give(tmp_path: Path) -> None:
    light = customize("Hopper", [Gravity(0.3)], max_steps=500)
    assert load_group(write(tmp_path, LIGHT)) == TaskGroup("hopper-light", (task("Hopper"), light))


def test_a_custom_group_has_an_id_and_is_not_published(tmp_path: Path) -> None:
    light = load_group(write(tmp_path, LIGHT))
    assert (light.id, light.published) == ("hopper-light-v0", False)
    assert light.task_ids == ("gym_extensions/Hopper-v0", "gym_extensions/Hopper.Gravity-0.3.steps-500-v0")
    assert group("hopper-gravity").published
    assert load_group(write(tmp_path, f"version = 2\n{LIGHT}")).id == "hopper-light-v2"


def test_a_name_a_path_and_an_object_resolve_to_their_group(tmp_path: Path) -> None:
    for name in ("hopper-gravity", "hopper-gravity-v0"):
        assert resolve_group(name) is group("hopper-gravity")
    path = write(tmp_path, LIGHT)
    assert resolve_group(path) == resolve_group(str(path)) == resolve_group(load_group(path))
    with refused("unreadable-group", where=str(tmp_path / "none.toml")):
        resolve_group(tmp_path / "none.toml")


@pytest.mark.parametrize(
    ("wrong", "code", "at", "fact"),
    [
        (LIGHT.replace("max_steps", "max_step"), "unknown-key", ", task 2", "'max_steps'"),
        (LIGHT.replace("name =", "nme ="), "unknown-key", "", "'name'"),
        ('name = "light"', "missing-key", "", "tasks"),
        (LIGHT.replace('"Hopper"\nvar', '"Hoper"\nvar'), "unknown-task", ", task 2", "'Hopper'"),
        (LIGHT.replace('"Hopper"\nvar', '"Pendulun-v1"\nvar'), "unknown-task", ", task 2", "'Pendulun-v1'"),
        (LIGHT.replace('"Hopper"\nvar', '"none:Own-v0"\nvar'), "unknown-task", ", task 2", "'none'"),
        (LIGHT.replace('"Gravity"', '"Gravty"'), "unknown-variation", ", task 2", "'Gravity'"),
        (LIGHT.replace("factor", "facter"), "unknown-key", ", task 2, Gravity", "'factor'"),
        (LIGHT.replace(", factor = 0.3", ""), "missing-key", ", task 2, Gravity", "factor"),
        (LIGHT.replace('kind = "Gravity", ', ""), "missing-key", ", task 2", "kind"),
        (LIGHT.replace("0.3", "-1"), "bad-factor", ", task 2", "above 0"),
        (LIGHT.replace("0.3", "1.0").replace(EXTRA, ""), "duplicate-task", "", "Hopper-v0"),
        (LIGHT.replace("hopper-light", "hopper-gravity"), "name-taken", "", "hopper-gravity"),
        (LIGHT.replace("hopper-light", "../up"), "bad-group", "", "../up"),
        (LIGHT.replace("500", "0"), "bad-limit", ", task 2", "max_steps is 0"),
        ("name = ", "malformed-group", "", "not TOML"),
    ],
)
def test_a_mistake_is_named_with_its_place(wrong: str, code: str, at: str, fact: str, tmp_path: Path) -> None:
    path = write(tmp_path, wrong)
    with refused(code, fact, where=f"{path}{at}"):
        load_group(path)


def test_a_version_may_be_an_integer_of_numpy() -> None:
    version: Any = np.int64(2)
    assert TaskGroup("light", (customize("Hopper"),), version).id == "light-v2"

"""Which policies Play offers, the file in which the browser gets them, and the pinned simulator."""

import gzip
import hashlib
import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gym_extensions.catalog.bodies import BODIES
from gym_extensions.catalog.groups import group
from gym_extensions.catalog.tasks import Task, task
from gym_extensions.references import experts
from gym_extensions.site import FOLDER
from gym_extensions.site.build import Site
from gym_extensions.site.pages import PAGES
from gym_extensions.site.pages.page import Render
from gym_extensions.site.play import assets
from gym_extensions.submissions.layout import run_file
from gym_extensions.submissions.policies.files import npz_arrays, write_policies
from gym_extensions.submissions.policies.mlp import Policy

from ...conftest import refused
from ..browser import references_of, typed
from ..conftest import everything, learner, make_submission, scored

Built = Callable[..., dict[str, bytes | str]]
"""Gives the files of Play for the folders of submissions."""
SIMULATOR = assets.Simulator(b"script", b"packed", b"licence")
GROUP = "hopper-gravity-v0"
PLAY = tuple(page for page in PAGES if page.path == "play.html")


def hopper_policy(seed: int) -> Policy:
    rng = np.random.default_rng(seed)
    first, second = rng.normal(size=(11, 4)).astype("f4"), rng.normal(size=(4, 3)).astype("f4")
    return Policy(
        action_offset=np.zeros(3, "f4"),
        action_scale=np.ones(3, "f4"),
        weights=(first, second),
        biases=(np.zeros(4, "f4"), np.zeros(3, "f4")),
        activation="tanh",
        observation_mean=np.arange(11.0),
        observation_scale=np.ones(11),
    )


def write_runs(folder: Path) -> Path:
    """A submission that has nothing but the policies of two runs on hopper-gravity."""
    for run in (0, 1):
        path = folder / run_file("hopper-gravity", "sequential", run, ".npz")
        path.parent.mkdir(parents=True, exist_ok=True)
        write_policies(path, {(stage, None): hopper_policy(stage) for stage in range(6)})
    return folder


@pytest.fixture
def built(monkeypatch: pytest.MonkeyPatch) -> Built:
    """The files of Play for a site in which two submissions trained on hopper-gravity, with one expert."""
    monkeypatch.setattr(experts, "names", lambda: ["Hopper", "Pusher"])

    def build(
        folders: dict[str, Path], simulator: assets.Simulator | None = SIMULATOR
    ) -> dict[str, bytes | str]:
        scores = {"better": learner(0.9, 0.9, 5), "worse": learner(0.3, 0.9, 5)}
        submissions = [
            make_submission(name, {GROUP: {"sequential": scored("hopper-gravity", matrices)}})
            for name, matrices in scores.items()
        ]
        cards = typed({**everything(), "submissions": submissions})
        site = Site(Render(references_of(cards), PLAY, folders, simulator))
        return {
            path: content
            for path, content in site.files(cards.submissions)
            if isinstance(content, bytes | str) and path.startswith("play")
        }

    return build


def test_a_policy_file_has_every_array_as_the_script_reads_it() -> None:
    policy = hopper_policy(0)
    swapped = {
        name: np.asarray(each, each.dtype.newbyteorder(">"), order="F")
        for name, each in policy.arrays().items()
    }
    found = npz_arrays(assets.policy_file(swapped))
    assert Policy.from_arrays(found).flat_weights().tolist() == policy.flat_weights().tolist()
    assert all(each.dtype.byteorder in "=|<" and each.flags.c_contiguous for each in found.values())


def test_play_offers_bodies_whose_rules_the_script_has() -> None:
    assert assets.is_playable(task("HopperBigFoot"))
    refused = map(task, ("HopperMotorNoise", "HopperNoisyWall", "Pusher"))
    assert not any(map(assets.is_playable, refused))
    groups = {each.name for each in assets.playable_groups()}
    assert {"hopper-gravity", "humanoid-wall", "humanoid-standup-run"} <= groups
    assert not {"pusher", "nav-state", "hopper-noisy-wall"} & groups
    assert assets.play_link(task("HopperWall")) == "play.html#?task=HopperWall"
    assert [assets.play_link(task("Pusher")), assets.play_group_link("nav-state-v0")] == ["", ""]
    assert assets.is_playable(in_no_group := task("HalfCheetahBigHead"))
    assert assets.play_link(in_no_group) == ""


def test_play_offers_no_body_without_rules_in_the_script(monkeypatch: pytest.MonkeyPatch) -> None:
    script = (FOLDER / "static" / "play" / "rules.js").read_text(encoding="utf-8")
    table = script.partition("export const RULES = {\n")[2].partition("\n};")[0]
    assert re.findall(r"^  (\w+): ", table, re.MULTILINE) == [body.name for body in assets.PLAYED]
    monkeypatch.setitem(BODIES, "Monopod", replace(BODIES["Hopper"], name="Monopod"))
    assert not assets.is_playable(Task("Monopod", "Monopod"))


def test_the_index_says_how_the_world_of_a_task_differs(built: Built) -> None:
    tasks = json.loads(built({})["play/index.json"])["tasks"]
    assert set(tasks) == {each.name for group in assets.playable_groups() for each in group.tasks}
    wall, foot = tasks["HopperWall"], tasks["HopperBigFoot"]
    assert (wall["gravity"], wall["limbs"], wall["wall"]) == (1.0, {}, True)
    assert (foot["limbs"], foot["wall"]) == ({"Foot": 1.25}, False)
    assert tasks["HopperWithSensor"]["wall"] is False
    assert (tasks["Hopper"]["expert"], tasks["HopperWall"].get("expert")) == ("play/experts/hopper.npz", None)
    assert tasks["HopperGravityHalf"]["gravity"] == 0.5


def test_every_submission_is_offered_with_its_first_run_before_another_run_is(
    built: Built, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folders = {name: write_runs(tmp_path / name) for name in ("better", "worse")}
    sizes = [len(content) for path, content in built(folders).items() if path.endswith(".npz")]
    monkeypatch.setattr(assets, "MAX_BYTES", sum(sizes) - 1)
    files = built(folders)
    [hopper] = [row for row in json.loads(files["play/index.json"])["groups"] if row["id"] == GROUP]
    assert hopper["tasks"] == [each.name for each in group("hopper-gravity").tasks]
    runs = {name: [run for run, *_ in each["runs"]] for name, each in hopper["submissions"].items()}
    assert runs == {"better": [0, 1], "worse": [0]}
    assert "not offered here" not in str(files["play.html"])


@pytest.mark.parametrize(
    ("damage", "why"),
    [
        pytest.param(lambda path: path.unlink(), assets.NO_POLICIES, id="none"),
        pytest.param(lambda path: path.write_bytes(b"ONNX"), assets.NOT_ARRAYS, id="another format"),
    ],
)
def test_a_submission_that_cannot_be_played_is_named_with_the_reason(
    built: Built, tmp_path: Path, damage: Callable[[Path], object], why: str
) -> None:
    folder = write_runs(tmp_path / "better")
    for path in list(folder.rglob("*.npz")):
        damage(path)
    files = built({"better": folder, "worse": write_runs(tmp_path / "worse")})
    assert not any(path.startswith("play/better") for path in files)
    assert why in str(files["play.html"])


def test_a_site_without_the_simulator_says_how_to_get_it(built: Built) -> None:
    files = built({}, None)
    assert set(files) == {"play.html"}
    page, with_simulator = str(files["play.html"]), str(built({})["play.html"])
    assert "make site-assets" in page
    assert '<script src="static/play.js"' not in page
    assert "script-src 'self' 'unsafe-eval'; connect-src 'self';" in with_simulator
    assert "unsafe-eval" not in page
    assert "Not part of any score." in with_simulator


def write_assets(folder: Path, script: bytes = b"script", wasm: bytes = b"wasm") -> Path:
    folder.mkdir()
    (folder / "mujoco.js").write_bytes(script)
    (folder / "mujoco.wasm.gz").write_bytes(gzip.compress(wasm))
    return folder


def test_the_simulator_is_read_only_if_it_is_the_pinned_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    digests = {f"mujoco.{name}": hashlib.sha256(name.encode()).hexdigest() for name in ("js", "wasm")}
    monkeypatch.setattr(assets, "SHA256", digests)
    assert assets.load(tmp_path / "none") is None
    simulator = assets.load(write_assets(tmp_path / "right", b"js", b"wasm"))
    assert simulator is not None
    assert b"Apache License" in simulator.license
    assert set(simulator.files()) == {"play/mujoco.js", "play/mujoco.wasm.packed", "play/LICENSE-mujoco.txt"}
    with refused("bad-asset", "mujoco.wasm is not the one", "make site-assets"):
        assets.load(write_assets(tmp_path / "wrong", b"js", b"other"))
    (tmp_path / "right" / "mujoco.js").unlink()
    with refused("bad-asset", "No such file"):
        assets.load(tmp_path / "right")

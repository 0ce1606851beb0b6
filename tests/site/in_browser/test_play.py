"""Play in a browser: physics and rules against the environments, the controls, and what can fail.

Without the simulator, which ``make site-assets`` fetches, the tests are skipped. MuJoCo for the browser is
3.14, the environments' is newer. Measured over 50 steps, observations of planar bodies agree to 4e-5,
positions of the humanoids to 0.02 and their rewards to 0.1; their velocities and forces differ at contacts.
"""

from collections.abc import Iterator
from typing import Any, Literal, NamedTuple

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from gym_extensions.catalog.tasks import task
from gym_extensions.catalog.variations import Wall
from gym_extensions.envs.mujoco.env import TaskEnv
from gym_extensions.references import experts
from gym_extensions.site.play.assets import policy_file
from gym_extensions.submissions.policies.files import npz_bytes

from ...submissions.policies.test_arithmetic import policies, seen
from ..play.test_assets import hopper_policy
from .made_site import ASSETS, Browser, Page
from .test_layout import SERIOUS, WIDE, axe
from .test_loading import reports

pytestmark = pytest.mark.skipif(not ASSETS.is_dir(), reason="the simulator is not there (make site-assets)")
STARTS, STEPS = 10, 50

WORLD = """async ([name, options]) => {
  const from = (path) => import(new URL(path, location.href));
  const [{ World, loadMujoco }, { readPolicies }] = await Promise.all(
    ["static/play/world.js", "static/play/policy.js"].map(from));
  const index = await (await fetch("play/index.json")).json();
  globalThis.mujoco ||= await loadMujoco(index.mujoco, new URL(".", location.href));
  const task = index.tasks[name], body = index.bodies[task.body];
  const world = new World(mujoco, body, mujoco.parseXMLString(await (await fetch(body.model)).text()));
  world.change({ gravity: task.gravity, limbs: task.limbs, wall: options.wall ?? null });
  const [expert] = await readPolicies(await (await fetch(task.expert)).arrayBuffer());
  %s
}"""
FOLLOW = """
  world.reset(options);
  const rows = [];
  for (const action of options.actions) {
    const observation = world.observe(expert.inputs), chosen = [...expert.act(observation)];
    rows.push({ observation, chosen, reward: world.step(action), ended: world.fell });
  }
  return rows;"""
EPISODES = """
  return options.starts.map((start) => {
    world.reset(start);
    while (!world.ended) world.step(expert.act(world.observe(expert.inputs)));
    return world.total;
  });"""
MEMORY = """
  const [part] = Object.keys(body.parts), bytes = [];
  for (let change = 0; change < 150; change++) {
    world.change({ limbs: { [part]: 0.5 + 0.05 * (change % 20) } });
    if (change % 50 === 49) bytes.push(world.data.qpos.buffer.byteLength);
  }
  return bytes;"""
ACT = """async ([bytes, observations, task]) => {
  const { readPolicies } = await import(new URL("static/play/policy.js", location.href));
  const [policy] = await readPolicies(new Uint8Array(bytes).buffer);
  return observations.map((observation) => [...policy.act(observation, task)]);
}"""


@pytest.fixture(scope="module")
def loaded(browser: Browser, http_address: str) -> Iterator[Page]:
    """The page, before the simulator is loaded."""
    context = browser.new_context(viewport={"width": 1300, "height": 900})
    context.set_default_timeout(120_000)
    page = context.new_page()
    page.goto(f"{http_address}play.html")
    yield page
    context.close()


def start(name: str, seed: int = 0) -> tuple[TaskEnv, dict[str, Any]]:
    """An environment in a start state near rest, and that state; a wall stands at 2.5 m."""
    env = TaskEnv(task(name))
    env.reset(seed=seed)
    rng = np.random.default_rng(seed)
    qpos = env.init_qpos + rng.uniform(-0.005, 0.005, env.model.nq)
    qvel = env.init_qvel + rng.uniform(-0.005, 0.005, env.model.nv)
    mujoco.mj_resetData(env.model, env.data)
    wall = next((each for each in env.task.variations if isinstance(each, Wall) and not each.parked), None)
    if wall is not None:
        env.data.mocap_pos[0] = 2.5, 0.0, wall.centre_height
    env.set_state(qpos, qvel)
    return env, {"qpos": qpos.tolist(), "qvel": qvel.tolist(), "wall": 2.5 if wall else None}


class Step(NamedTuple):
    """What the environment showed before a step, the expert's action, and what the step gave."""

    observation: NDArray[Any]
    action: NDArray[Any]
    reward: float
    ended: bool


def episode(env: TaskEnv, name: str, steps: int) -> list[Step]:
    """The first steps of an expert from the environment's present state."""
    policy, rows, observation = experts.load(name), list[Step](), env._get_obs()
    low, high = env.action_space.low, env.action_space.high
    while len(rows) < steps and not (rows and rows[-1].ended):
        action = np.clip(policy.act(observation[None])[0], low, high).astype(np.float32)
        after, reward, ended, _, _ = env.step(action)
        rows.append(Step(observation, action, float(reward), ended))
        observation = after
    return rows


PLANAR = ("Hopper", "Walker2d", "HalfCheetah", "HalfCheetahGravityHalf", "HalfCheetahBigTorso", "HopperWall")
QUICK = ("Hopper", "HalfCheetahBigTorso", "HopperWall", "Humanoid")
"""Those that run in ``make test``, too."""
HUMANOIDS = ("Humanoid", "HumanoidBigFoot", "HumanoidWall", "HumanoidStandup", "HumanoidStandupAndRun")


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in (*PLANAR, *HUMANOIDS)],
)
def test_the_script_follows_the_environment_step_by_step(loaded: Page, name: str) -> None:
    env, state = start(name)
    rows = episode(env, name, STEPS)
    state["actions"] = [row.action.astype(float).tolist() for row in rows]
    seen = loaded.evaluate(WORLD % FOLLOW, [name, state])
    np.testing.assert_allclose(seen[0]["observation"], rows[0].observation, rtol=1e-9, atol=1e-12)
    low, high = env.action_space.low, env.action_space.high
    np.testing.assert_allclose(np.clip(seen[0]["chosen"], low, high), rows[0].action, atol=1e-5)
    part, close, near = (slice(None), 1e-3, 1e-3) if name in PLANAR else (slice(0, 22), 0.05, 0.2)
    for row, step in zip(seen, rows, strict=True):
        np.testing.assert_allclose(row["observation"][part], step.observation[part], rtol=close, atol=close)
        assert row["reward"] == pytest.approx(step.reward, abs=near)
        assert row["ended"] == step.ended


@pytest.mark.parametrize("name", ["Hopper", "HalfCheetah"])
def test_an_expert_returns_what_it_returns_in_python(loaded: Page, name: str) -> None:
    """Small differences grow over an episode, so the mean over ten starts is compared."""
    returns, starts = [], []
    for seed in range(STARTS):
        env, state = start(name, seed)
        starts.append(state)
        returns.append(sum(step.reward for step in episode(env, name, env.task.max_steps)))
    seen = loaded.evaluate(WORLD % EPISODES, [name, {"starts": starts}])
    assert np.mean(seen) == pytest.approx(np.mean(returns), rel=0.02)


def test_a_part_that_is_changed_again_and_again_takes_no_more_memory(loaded: Page) -> None:
    first, _, last = loaded.evaluate(WORLD % MEMORY, ["Hopper", {}])
    assert last == first


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("name", policies())
def test_actions_have_the_bits_of_python_in_both_orders_of_an_array(
    loaded: Page, name: str, order: Literal["C", "F"]
) -> None:
    policy, observations = policies()[name], seen(30)
    file = npz_bytes({key: np.array(each, order=order) for key, each in policy.arrays().items()})
    for index in (0, 1, 4):
        given = [list(file), observations.tolist(), index]
        assert loaded.evaluate(ACT, given) == policy.act(observations, task=index).tolist()


@pytest.fixture
def panel(page: Page, http_address: str) -> Page:
    """The page with the simulator, on the second task of hopper-gravity."""
    page.set_viewport_size({"width": 1300, "height": 900})
    page.lines = reports(page, http_address, "play.html#?task=HopperGravityThreeQuarters")  # type: ignore[attr-defined]
    page.locator("#play-load").press("Enter")
    runs(page)
    return page


VALUES = "(menus) => menus.map((menu) => menu.value)"


def said(page: Page, selector: str, condition: str) -> None:
    """Waits until the text of an element meets a condition."""
    text = f"const text = document.querySelector('{selector}').textContent;"
    page.wait_for_function(f"() => {{ {text} return {condition}; }}")


def runs(page: Page) -> None:
    """Waits until the simulator runs."""
    page.wait_for_function("() => Number(document.querySelector('#play-status').dataset.ratio) > 0")


def caption(panel: Page, side: int) -> str:
    return panel.locator(".sides figcaption").nth(side).inner_text()


def walk(panel: Page) -> None:
    """The expert takes the place of the made policies, which fall at once."""
    panel.locator(".policy").first.select_option("/expert")
    said(panel, "#play-panel", "text.includes('experts.load')")  # it is there once its file is offered


def test_two_bodies_run_side_by_side_faster_than_real_time(panel: Page) -> None:
    policies = panel.locator("select.policy option:checked")
    assert policies.all_inner_texts() == ["Agile", "Agile"]
    assert panel.locator(".stage-of").evaluate_all(VALUES) == ["2", "5"], "after learning, and at the end"
    for stage in ("2: after HopperGravityThreeQuarters", "5: after HopperGravityOneAndHalf"):
        panel.get_by_role("img", name=f"Hopper under Agile, run 0, stage {stage}").wait_for()
    walk(panel)
    said(panel, ".sides figcaption", "/step \\d\\d/.test(text)")
    status = panel.locator("#play-status")
    assert status.inner_text().startswith("This is HopperGravityThreeQuarters.")
    assert float(status.get_attribute("data-ratio") or 0) > 1
    assert "× as fast as real time" in status.inner_text()
    assert all(caption(panel, side).startswith("Return ") for side in (0, 1))
    assert panel.lines == []  # type: ignore[attr-defined]


def test_the_keyboard_pauses_pushes_and_changes_the_world(panel: Page) -> None:
    walk(panel)
    panel.locator("#play-again").press("Enter")
    panel.locator("#play-run").press("Space")
    assert panel.locator("#play-run").inner_text() == "Play"
    paused = caption(panel, 0)
    panel.wait_for_timeout(100)
    assert caption(panel, 0) == paused
    panel.locator("#play-forward").press("Enter")
    said(panel, "#play-status", "text.includes('pushed')")
    panel.locator("#play-gravity").press("ArrowLeft")
    assert panel.locator("#play-gravity + output").inner_text() == "0.70 g"
    said(panel, "#play-status", "text.includes('no task')")
    panel.locator("#play-has-wall").press("Space")
    panel.locator("#play-factor").press("ArrowRight")
    assert panel.locator("#play-factor + output").inner_text() == "× 1.05"
    panel.locator("#play-run").press("Space")
    panel.locator("#play-group").select_option("humanoid-gravity-v0")
    said(panel, "#play-status", "text.startsWith('This is Humanoid')")
    assert panel.lines == []  # type: ignore[attr-defined]


def test_a_link_chooses_a_run_and_other_choices_are_right_after_learning_and_at_the_end(
    page: Page, http_address: str
) -> None:
    index = page.request.get(f"{http_address}play/index.json").json()
    groups = {group["id"]: group for group in index["groups"]}
    groups["hopper-body-v0"]["submissions"] = groups["hopper-gravity-v0"]["submissions"]
    page.route("**/index.json", lambda route: route.fulfill(json=index))
    page.goto(f"{http_address}play.html#?group=hopper-gravity-v0&submission=agile&run=1&stage=2")
    page.locator("#play-load").click()
    page.wait_for_function("() => document.querySelector('.stage-of').value === '2'")
    assert page.locator(".run-of").evaluate_all(VALUES) == ["1", "1"]
    assert page.locator(".stage-of").evaluate_all(VALUES) == ["2", "5"]
    page.locator("#play-group").select_option("hopper-body-v0")
    page.wait_for_function("() => document.querySelector('.stage-of').value === '1'")
    for policy, stage in (("/expert", "0"), ("agile", "1")):
        page.locator(".policy").first.select_option(policy)
        page.wait_for_function(f"() => document.querySelector('.stage-of').value === '{stage}'")


def test_the_mouse_pulls_a_body(panel: Page) -> None:
    walk(panel)
    canvas = panel.locator(".sides canvas").first
    box = canvas.bounding_box()
    assert box
    panel.locator("#play-again").click()
    panel.mouse.move(box["x"] + 0.47 * box["width"], box["y"] + 0.6 * box["height"])
    panel.mouse.down()
    panel.mouse.move(box["x"] + 0.2 * box["width"], box["y"] + 0.2 * box["height"])
    said(panel, "#play-status", "text.includes('pushed')")
    panel.mouse.up()


def test_a_wall_that_is_ticked_stands_in_front_of_the_body_and_stays(panel: Page) -> None:
    walk(panel)
    said(panel, ".sides figcaption", "parseFloat(text.split(', ')[2]) > 1")
    panel.locator("#play-has-wall").check()
    ahead = panel.evaluate("() => Number(document.getElementById('play-wall').value)")
    body = float(caption(panel, 0).split(", ")[2].split(" m")[0])
    assert body + 0.5 < ahead
    panel.locator("#play-again").click()
    assert panel.evaluate("() => Number(document.getElementById('play-wall').value)") == ahead


def test_the_address_follows_every_control_and_brings_it_back(panel: Page) -> None:
    panel.locator("#play-gravity").press("ArrowLeft")
    panel.locator("#play-factor").press("ArrowRight")
    panel.locator("#play-has-wall").check()
    panel.locator("#play-speed").select_option("2")
    panel.locator(".stage-of").first.select_option("3")
    panel.locator(".policy").nth(1).select_option("/expert")
    panel.wait_for_function("() => location.hash.includes('submission2=%2Fexpert&stage2=0')")
    address, controls = panel.url, "#play-panel select, #play-panel input"
    assert "stage=3" in address
    state = "(each) => each.map((e) => [e.id, e.type === 'checkbox' ? e.checked : e.value])"
    chosen = panel.locator(controls).evaluate_all(state)
    panel.reload()
    panel.locator("#play-load").press("Enter")
    runs(panel)
    assert panel.locator(controls).evaluate_all(state) == chosen
    assert panel.url == address


def test_finished_episodes_are_counted_and_policies_can_be_taken(panel: Page) -> None:
    panel.locator("#play-speed").select_option("4")
    said(panel, "figcaption", "/Fell in \\d of \\d finished/.test(text)")
    panel.get_by_text("Download").first.click()
    with panel.expect_download() as download:
        panel.get_by_role("link", name="The policies of this run").first.click()
    assert download.value.suggested_filename.endswith("-run0.npz")
    line = panel.locator(".download").first.locator("code").last.inner_text()
    assert '.load("submissions/agile", "hopper-gravity", run=0, stage=2)' in line


def test_an_episode_of_two_worlds_is_none_of_the_task_and_is_not_counted(panel: Page) -> None:
    walk(panel)
    panel.locator("#play-again").press("Enter")
    panel.locator("#play-gravity").press("ArrowLeft")
    panel.locator("#play-gravity").press("ArrowRight")
    said(panel, "#play-status", "text.includes('the world changed')")
    panel.locator("#play-speed").select_option("4")
    said(panel, ".sides figcaption", "/It fell|End of the episode/.test(text)")
    assert "finished" not in caption(panel, 0)
    panel.locator("#play-again").press("Enter")
    said(panel, "#play-status", "text.startsWith('This is HopperGravityThreeQuarters.')")


@pytest.mark.parametrize(("width", "height"), [(1440, 900), (390, 844)])
def test_body_and_return_are_on_the_first_screen_and_a_finger_scrolls_it(
    panel: Page, width: int, height: int
) -> None:
    panel.set_viewport_size({"width": width, "height": height})
    panel.evaluate("() => scrollTo(0, 0)")
    for element in (".sides canvas", ".sides figcaption"):
        box = panel.locator(element).first.bounding_box()
        assert box
        assert 0 < box["y"] < box["y"] + box["height"] < height
    touch = panel.locator(".sides canvas").first.evaluate("(canvas) => getComputedStyle(canvas).touchAction")
    assert touch == "pan-y pinch-zoom"


@pytest.mark.parametrize(
    ("address", "unknown"),
    [
        ("task=Hopper&group=nothing&part=Nose", "group nothing, part Nose"),
        ("task=Hopper&gravity=abc&wall=near", "gravity abc, wall near"),
        ("group=hopper-gravity-v0&task=HopperWall&stage=99", "task HopperWall, stage 99"),
        ("task=Hopper&submission=nobody&run2=7", "submission nobody, run2 7"),
    ],
)
def test_what_is_unknown_in_the_address_is_said(
    page: Page, http_address: str, address: str, unknown: str
) -> None:
    page.goto(f"{http_address}play.html#?{address}")
    page.locator("#play-load").click()
    runs(page)
    status = page.locator("#play-status").inner_text()
    assert status.startswith(f"This page has no {unknown}; shown is another.")


SLOW = """const load = fetch;
globalThis.fetch = async (address, ...rest) => {
  if (/\\.(npz|xml)$/.test(address)) await new Promise((done) => setTimeout(done, 500));
  return load(address, ...rest);
};"""


def test_of_two_addresses_the_second_counts_while_files_of_the_first_are_loaded(
    page: Page, http_address: str
) -> None:
    page.add_init_script(SLOW)
    page.goto(f"{http_address}play.html#?task=Hopper&submission=agile&run=0")
    page.locator("#play-load").click()
    page.wait_for_function("() => !document.getElementById('play-panel').hidden")
    page.evaluate("location.hash = '#?task=Hopper&gravity=1&submission=%2Fexpert'")
    runs(page)
    assert page.locator("select.policy").evaluate_all(VALUES) == ["/expert", "/expert"]
    assert page.locator("#play-status").inner_text().startswith("This is Hopper.")
    assert "submission=%2Fexpert&stage=0&submission2=%2Fexpert&stage2=0" in page.url


def test_the_panel_fits_a_narrow_screen_and_is_accessible(panel: Page) -> None:
    panel.evaluate(axe())
    assert panel.evaluate(SERIOUS, ["#none", {}]) == []
    panel.set_viewport_size({"width": 320, "height": 700})
    assert panel.evaluate(WIDE) == []


def problem(page: Page) -> str:
    """The sentence that the page shows instead of the bodies; it ends with a link to recorded episodes."""
    note = page.locator("#play-problem")
    note.wait_for()
    assert note.locator("a").get_attribute("href") == "tasks/hopper-v0.html"
    return note.inner_text()


def test_where_it_cannot_run_the_page_says_what_to_do(page: Page, address: str, http_address: str) -> None:
    assert reports(page, address, "play.html") == []
    assert "python -m http.server" in problem(page)
    assert not page.locator("#play-load").is_visible()
    page.add_init_script("delete globalThis.WebAssembly")
    page.goto(f"{http_address}play.html")
    assert "Play needs WebAssembly." in problem(page)


@pytest.mark.parametrize(
    "reply", [{"body": b"other bytes"}, {"status": 404}], ids=["another digest", "missing"]
)
def test_a_simulator_that_is_not_the_built_one_is_not_run(
    page: Page, http_address: str, reply: dict[str, Any]
) -> None:
    page.route("**/mujoco.wasm.packed", lambda route: route.fulfill(**reply))
    page.goto(f"{http_address}play.html")
    page.locator("#play-load").click()
    assert "The simulator did not load." in problem(page)
    assert page.locator("#play-problem").evaluate("(note) => note === document.activeElement")
    assert not page.locator("#play-panel").is_visible()


def test_policies_of_an_unknown_format_are_named(page: Page, http_address: str) -> None:
    content = policy_file(hopper_policy(0).arrays() | {"format": np.array(2)})
    page.route("**/agile/*.npz", lambda route: route.fulfill(body=content))
    page.goto(f"{http_address}play.html")
    page.locator("#play-load").click()
    page.wait_for_function(
        "() => document.querySelectorAll('.sides figcaption')[1].textContent.includes('format 2')"
    )
    assert caption(page, 1).startswith("Agile, run 0: ")

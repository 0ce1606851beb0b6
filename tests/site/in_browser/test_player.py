"""The Watch panel in a browser: play and pause, the time and the speed, by mouse and by keyboard."""

import pytest

from .made_site import PAGES, Locator, Visit

DARK_PIXELS = """(canvas) => {
  const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  let count = 0;
  for (let at = 3; at < data.length; at += 4) count += data[at] > 0;
  return count;
}"""


@pytest.fixture
def panel(visit: Visit) -> Locator:
    """The panel of the first task of a submission."""
    return visit(PAGES["submission"]).locator(".watch").first


def test_replay_draws_both_episodes_and_pause_stops_the_time(panel: Locator) -> None:
    assert panel.locator("svg.strobe:visible").count() == 2
    assert panel.locator("canvas").count() == 0
    labels = [svg.get_attribute("aria-label") for svg in panel.locator("svg.strobe").all()]
    panel.get_by_role("button", name="Replay").click()
    time = panel.get_by_role("slider")
    time.wait_for()
    panel.page.wait_for_function("(input) => Number(input.value) > 2", arg=time.element_handle())
    assert panel.locator("canvas:visible").count() == 2
    assert panel.locator("svg.strobe:visible").count() == 0
    for canvas in panel.locator("canvas").all():
        assert canvas.evaluate(DARK_PIXELS) > 100
    assert [canvas.get_attribute("aria-label") for canvas in panel.locator("canvas").all()] == labels
    assert all(labels)
    panel.get_by_role("button", name="Pause").click()
    stopped = time.input_value()
    panel.page.wait_for_timeout(100)
    assert time.input_value() == stopped


def test_the_page_of_a_task_replays_its_expert(visit: Visit) -> None:
    panel = visit(PAGES["task"]).locator(".watch").first
    panel.get_by_role("button", name="Replay").click()
    panel.get_by_role("button", name="Pause").wait_for()


def test_the_keyboard_plays_scrubs_and_changes_the_speed(panel: Locator) -> None:
    button = panel.locator("button.play")
    button.press("Enter")
    time = panel.get_by_role("slider")
    time.wait_for()
    button.press("Space")
    assert button.inner_text() == "Replay"
    time.press("Home")
    assert panel.locator("output").inner_text() == "0.0 s"
    time.press("End")
    assert panel.locator("output").inner_text() == "4.0 s"
    assert time.get_attribute("aria-valuetext") == "4.0 s"
    assert panel.locator("output").get_attribute("aria-live") == "off", "it changes ten times per second"
    time.press("ArrowLeft")
    assert float(time.input_value()) < 60
    speed = panel.get_by_label("Speed")
    speed.select_option("4 ×")
    assert speed.input_value() == "4"

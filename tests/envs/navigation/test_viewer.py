"""The window of ``render_mode="human"``, with the display's library replaced by one that takes notes."""

from __future__ import annotations

import sys
from types import ModuleType, SimpleNamespace
from typing import Any

import glfw
import numpy as np
import pytest

from gym_extensions.envs import make
from gym_extensions.errors import BenchError

NAME = "Limited-Range-Based-Navigation-2d-Map1-Goal0"


@pytest.fixture
def shown(monkeypatch: pytest.MonkeyPatch) -> list[np.ndarray]:
    """The frames that were drawn, first row at the top, and None for a closed window."""
    frames: list[Any] = []
    library = ModuleType("glfw")
    vars(library).update(
        init=lambda: True,
        create_window=lambda width, height, title, monitor, share: (width, height, title),
        make_context_current=lambda window: None,
        get_framebuffer_size=lambda window: window[:2],
        swap_buffers=lambda window: None,
        poll_events=lambda: None,
        destroy_window=lambda window: frames.append(None),
    )
    nothing = dict.fromkeys(("glViewport", "glPixelStorei", "glPixelZoom", "glRasterPos2f"), lambda *_: None)
    names = dict.fromkeys(("GL_UNPACK_ALIGNMENT", "GL_RGB", "GL_UNSIGNED_BYTE"), 0)

    def draw(width: int, height: int, layout: int, kind: int, pixels: np.ndarray) -> None:
        assert pixels.shape == (height, width, 3)
        frames.append(pixels[::-1].copy())

    package = ModuleType("OpenGL")
    package.GL = SimpleNamespace(**nothing, **names, glDrawPixels=draw)  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "glfw", library)
    monkeypatch.setitem(sys.modules, "OpenGL", package)
    return frames


def test_a_window_shows_the_frame_of_every_reset_and_step(shown: list[np.ndarray]) -> None:
    window, frames = make(NAME, render_mode="human"), make(NAME, render_mode="rgb_array")
    window.reset(seed=3)
    frames.reset(seed=3)
    expected = [frames.render()]
    for action in np.full((3, 2), 2.0, np.float32):
        window.step(action)
        frames.step(action)
        expected.append(frames.render())
    np.testing.assert_array_equal(shown, expected)
    assert not np.array_equal(expected[0], expected[-1])
    window.close()
    window.close()
    assert shown.pop() is None
    assert len(shown) == 4


def test_without_a_display_the_error_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(glfw, "init", lambda: False)
    with pytest.raises(BenchError) as refused:
        make(NAME, render_mode="human").reset(seed=0)
    assert refused.value.code == "no-display"
    assert str(refused.value) == (
        f'{NAME}: No window can be opened. Set DISPLAY, or use render_mode="rgb_array".'
    )


def test_rendering_without_a_mode_warns_and_gives_nothing() -> None:
    env = make(NAME).unwrapped
    env.reset(seed=0)
    with pytest.warns(UserWarning, match="there is nothing to render"):
        assert env.render() is None

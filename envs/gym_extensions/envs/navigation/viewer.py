"""A window that shows frames, for ``render_mode="human"``."""

from __future__ import annotations

import time
import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gym_extensions.errors import BenchError


class Window:
    """Opened by the first frame, with GLFW and OpenGL, as MuJoCo opens its own."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._window: Any = None
        self._due = 0.0

    def show(self, frame: NDArray[np.uint8], frames_per_second: int) -> None:
        """Shows a frame (rows, columns, 3), first row at the top, and waits until the next one is due.

        Raises:
            BenchError: no window can be opened.
        """
        import glfw
        from OpenGL import GL

        if self._window is None:
            self._window = self._open(frame.shape[1], frame.shape[0])
        glfw.make_context_current(self._window)
        width, height = glfw.get_framebuffer_size(self._window)
        GL.glViewport(0, 0, width, height)
        GL.glPixelStorei(GL.GL_UNPACK_ALIGNMENT, 1)
        GL.glPixelZoom(width / frame.shape[1], height / frame.shape[0])
        # OpenGL draws from the lower left corner upwards.
        upwards = np.ascontiguousarray(frame[::-1])
        GL.glRasterPos2f(-1.0, -1.0)
        GL.glDrawPixels(frame.shape[1], frame.shape[0], GL.GL_RGB, GL.GL_UNSIGNED_BYTE, upwards)
        glfw.swap_buffers(self._window)
        glfw.poll_events()
        time.sleep(max(0.0, self._due - time.monotonic()))
        self._due = time.monotonic() + 1.0 / frames_per_second

    def close(self) -> None:
        """Closes the window, if it is open."""
        if self._window is not None:
            import glfw

            glfw.destroy_window(self._window)
            self._window = None

    def _open(self, width: int, height: int) -> Any:
        import glfw

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            window = glfw.create_window(width, height, self._title, None, None) if glfw.init() else None
        if not window:
            hint = 'Set DISPLAY, or use render_mode="rgb_array".'
            raise BenchError("no-display", "No window can be opened.", self._title, hint)
        return window

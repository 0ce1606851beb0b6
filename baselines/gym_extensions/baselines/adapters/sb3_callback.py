"""The user's callbacks inside ``learn``, with a named error when they fail."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback, CallbackList, ConvertCallback

from gym_extensions.errors import BenchError

Callback = BaseCallback | Sequence[BaseCallback] | Callable[[dict[str, Any], dict[str, Any]], bool] | None
"""What SB3's ``learn(callback=…)`` accepts."""


class NamedErrors(BaseCallback):
    """Calls another callback and turns its exception into a :class:`BenchError` that names it."""

    def __init__(self, callback: BaseCallback) -> None:
        super().__init__()
        self._callback = callback

    def _call(self, method: str, *arguments: Any) -> Any:
        try:
            return getattr(self._callback, method)(*arguments)
        except BenchError:
            raise
        except Exception as error:
            raise BenchError(
                "callback-failed",
                f"{_name(self._callback)} raised {type(error).__name__}: {error}.",
                where=f"{method}() at step {self.num_timesteps} of learn()",
                hint="Correct the callback and repeat the command; finished stages are not repeated.",
            ) from error

    def init_callback(self, model: BaseAlgorithm) -> None:
        """Passes the model on."""
        super().init_callback(model)
        self._call("init_callback", model)

    def _on_training_start(self) -> None:
        self._call("on_training_start", self.locals, self.globals)

    def _on_rollout_start(self) -> None:
        self._call("on_rollout_start")

    def _on_step(self) -> bool:
        return bool(self._call("on_step"))

    def _on_rollout_end(self) -> None:
        self._call("on_rollout_end")

    def _on_training_end(self) -> None:
        self._call("on_training_end")

    def update_child_locals(self, locals_: dict[str, Any]) -> None:
        """Passes the local variables on."""
        self._call("update_locals", locals_)


def with_named_errors(callback: Callback) -> BaseCallback | None:
    """The callback as SB3's ``learn`` accepts it; each callback of a list is named in its own errors."""
    if callback is None:
        return None
    if isinstance(callback, BaseCallback):
        return NamedErrors(callback)
    if callable(callback):
        return NamedErrors(ConvertCallback(callback))
    return CallbackList([NamedErrors(each) for each in callback])


def _name(callback: BaseCallback) -> str:
    function = getattr(callback, "callback", None)
    if isinstance(callback, ConvertCallback) and function is not None:
        return f"The callback {getattr(function, '__name__', type(function).__name__)}"
    return f"The callback {type(callback).__name__}"

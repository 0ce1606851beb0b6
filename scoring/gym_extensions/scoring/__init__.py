"""Computes scores, intervals and boards from submitted rollout logs. Loads no simulator and no torch.

Example:
    >>> from gym_extensions.scoring import score_folder
    >>> score_folder("submissions/trpo").title
    'TRPO'
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gym_extensions.scoring.pipeline import score_folder, score_folders

__all__ = ["score_folder", "score_folders"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from gym_extensions.scoring import pipeline  # on first use: loads no other subpackage

    return getattr(pipeline, name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])

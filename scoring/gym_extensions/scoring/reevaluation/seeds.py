"""New seeds, which nobody knew when the submission was made."""

from __future__ import annotations

import hashlib

from gym_extensions.catalog.protocol import EVALUATION_EPISODES


def new_seed(digest: str, salt: str, *names: object) -> int:
    """A seed below 2³¹ that follows from a submission, a salt and names.

    It is the first four bytes, little-endian, top bit cleared, of the SHA-256 of
    ``<digest>/<salt>/<name>/…``, as the prescribed seeds are of theirs.

    Args:
        digest: the digest of the submission.
        salt: a value that was fixed after the submission.
        names: what the seed is for.
    """
    text = "/".join(map(str, (digest, salt, *names)))
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:4], "little") & 0x7FFFFFFF


def new_seeds(digest: str, salt: str, group_id: str, task_id: str) -> list[int]:
    """The reset seeds of a task's new episodes: the same for all runs, stages and protocols."""
    episodes = range(EVALUATION_EPISODES)
    return [new_seed(digest, salt, group_id, task_id, episode) for episode in episodes]

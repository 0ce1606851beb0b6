"""The segments of a recorded episode, each replayed on its own."""

from __future__ import annotations

from dataclasses import dataclass

from gym_extensions.rollouts.trace_reader import RecordedEpisode


@dataclass(frozen=True)
class Segment:
    """The ``index``-th segment of an episode, from step ``start`` to ``end`` (exclusive)."""

    episode: RecordedEpisode
    index: int
    start: int
    end: int

    @property
    def last(self) -> bool:
        """Whether the episode ends with it."""
        return self.end == self.episode.length


def segments_of(episode: RecordedEpisode) -> list[Segment]:
    """The segments of an episode, in order."""
    starts = range(0, episode.length, episode.segment_steps)
    ends = [*starts[1:], episode.length]
    return [
        Segment(episode, index, start, end)
        for index, (start, end) in enumerate(zip(starts, ends, strict=True))
    ]

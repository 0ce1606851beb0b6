"""Which tests run in the same worker of pytest-xdist.

The tests of a file share its fixtures, so they run in one worker. Some files share more: the tests of the
pages share a built site and a Chromium, and the first use of torch in a process takes five seconds.
"""

from __future__ import annotations

from xdist.scheduler import LoadFileScheduling

GROUPS = {
    "tests/site/in_browser/": "chromium",
    "tests/examples/": "torch",
    "tests/baselines/adapters/": "torch",
    "tests/baselines/test_submit_doc.py": "torch",
}
"""The folders and files whose tests form a group, with the name of the group."""


def worker_group(nodeid: str) -> str | None:
    """The group of a test, if it is in one."""
    return next((name for path, name in GROUPS.items() if nodeid.startswith(path)), None)


class Scheduler(LoadFileScheduling):  # type: ignore[misc]
    """Gives all tests of a group, or else of a file, to one worker."""

    def _split_scope(self, nodeid: str) -> str:
        return worker_group(nodeid) or str(super()._split_scope(nodeid))

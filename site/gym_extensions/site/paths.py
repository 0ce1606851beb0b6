"""The paths of pages and data.

A path depends on a name alone, so that a new submission moves no page. Paths are relative to the root of the
site.
"""

import hashlib
import re
from dataclasses import dataclass

MAX_SLUG = 80


def slug(name: str) -> str:
    """A file name without suffix, safe in file systems and URLs: ``[a-z0-9_-]``, at most 93 characters.

    Different names have different slugs, even where case is ignored: a name that has to change gets its
    digest behind an underscore, which no unchanged name contains.
    """
    plain = re.sub(r"[^a-z0-9-]+", "-", name.lower()).strip("-")[:MAX_SLUG]
    if plain == name:
        return plain
    return f"{plain}_{hashlib.sha256(name.encode('utf-8', 'surrogatepass')).hexdigest()[:12]}"


def submission_path(name: str) -> str:
    """The page of a submission, by the name of its folder."""
    return f"submissions/{slug(name)}.html"


def results_path(name: str, group_id: str) -> str:
    """The results of a submission on one group, where they are not on its own page."""
    return f"submissions/{slug(name)}/{slug(group_id)}.html"


def group_path(group_id: str) -> str:
    """The page of a group or suite, for example ``groups/hopper-gravity-v0.html``."""
    return f"groups/{slug(group_id)}.html"


def task_path(task_id: str) -> str:
    """The page of a task, for example ``tasks/hopperwall-v0.html``. The namespace is not part of it."""
    return f"tasks/{slug(task_id.rsplit('/', maxsplit=1)[-1].lower())}.html"


def board_path(board_id: str) -> str:
    """The table of all rows of a board."""
    return f"boards/{slug(board_id.lower())}.html"


def board_tab(group_id: str, board_id: str) -> str:
    """A board on the page of its group."""
    return f"{group_path(group_id)}#{board_id}"


def submission_data(name: str) -> str:
    """The scorecard of a submission."""
    return f"api/submissions/{slug(name)}.json"


def summary_data(name: str) -> str:
    """The scores of a submission without what they are computed from."""
    return f"api/summaries/{slug(name)}.json"


def board_data(board_id: str, suffix: str = "json") -> str:
    """A board as JSON, its table as ``csv``, or the differences of its submissions as ``pairs.js``."""
    return f"api/boards/{slug(board_id.lower())}.{suffix}"


INDEX_DATA = "api/index.json"
"""All data by path. A folder with this file is a built site."""
CORE_DATA = "api/core.json"
"""The core board."""
BEST_DATA = "api/best.json"
"""The submissions with the highest returns, by task."""
FEED = "feed.xml"
"""What changed, as Atom."""
COMPARED = "api/compare.js"
"""What the page Compare loads first."""


def group_data(group_id: str) -> str:
    """A group or suite with its tasks and boards."""
    return f"api/groups/{slug(group_id)}.json"


def submission_file(name: str, file: str) -> str:
    """A file that belongs to the page of a submission, by the names of its folder and of the file."""
    return f"submissions/{slug(name)}/{file}"


def number_file(name: str, *board: str) -> str:
    """What the numbers of a submission open: on a board, by group, protocol and budget, or on the core."""
    return submission_file(name, f"{slug('-'.join(board).lower() or 'core')}.js")


@dataclass(frozen=True)
class Source:
    """Where the data of a site is from. Each fact may be empty."""

    repository: str = ""  # its address, without a slash at the end
    commit: str = ""
    date: str = ""  # of the commit, YYYY-MM-DD
    is_changed: bool = False  # whether files differ from the commit
    version: str = ""  # of gym-extensions
    url: str = ""  # where the pages will be, without a slash at the end

    def link(self, path: str) -> str:
        """The address of a file or folder of the repository at this commit, as GitHub and GitLab have it."""
        return f"{self.repository}/tree/{self.commit or 'HEAD'}/{path}"


NOWHERE = Source()

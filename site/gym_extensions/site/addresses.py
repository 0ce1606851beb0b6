"""The paths of pages that other pages link to, relative to the root of the site.

A path depends on a name alone, so that a new entry moves no page.
"""

from __future__ import annotations

import hashlib
import re

MAX_SLUG = 80


def slug(name: str) -> str:
    """A file name without suffix, safe in file systems and URLs: ``[a-z0-9_-]``, at most 93 characters.

    Different names have different slugs, even where case is ignored: a name that has to change gets its digest
    behind an underscore, which no unchanged name contains.
    """
    plain = re.sub(r"[^a-z0-9-]+", "-", name.lower()).strip("-")[:MAX_SLUG]
    if plain == name:
        return plain
    return f"{plain}_{hashlib.sha256(name.encode('utf-8', 'surrogatepass')).hexdigest()[:12]}"


def entry_path(name: str) -> str:
    """The page of a submission, by the name of its folder."""
    return f"submissions/{slug(name)}.html"


def group_path(group_id: str) -> str:
    """The page of a group or suite, for example ``groups/hopper-gravity-v0.html``."""
    return f"groups/{slug(group_id)}.html"


def task_path(task_id: str) -> str:
    """The page of a task, for example ``tasks/hopperwall-v0.html``. The namespace is not part of it."""
    return f"tasks/{slug(task_id.rsplit('/', maxsplit=1)[-1].lower())}.html"

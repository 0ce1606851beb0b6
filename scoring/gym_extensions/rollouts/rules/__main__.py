"""Writes the table of rules into docs/rollout-log.md, between its markers.

python -m gym_extensions.rollouts.rules docs/rollout-log.md
"""

import sys
from pathlib import Path

from gym_extensions.atomic import write_text
from gym_extensions.rollouts.rules.table import with_table

page = Path(sys.argv[1])
write_text(page, with_table(page.read_text(encoding="utf-8")))

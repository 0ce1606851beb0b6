"""From folders to scorecards and boards, in parallel."""

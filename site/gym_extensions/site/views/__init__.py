"""What the templates show, computed from scorecards, boards and measurements."""

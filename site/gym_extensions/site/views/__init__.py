"""What the templates show, computed from scorecards and boards."""

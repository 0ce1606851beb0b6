"""From scores to pages: a static leaderboard of the scorecard document. Loads no simulator, no torch."""

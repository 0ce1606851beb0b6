"""Published results without logs: the tables as printed, and what is known about their numbers."""

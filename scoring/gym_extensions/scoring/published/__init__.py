"""Published results without logs, as printed, with findings about their numbers."""

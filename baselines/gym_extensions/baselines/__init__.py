"""Reference agents, and the loop that runs any agent through a protocol and writes its submission."""

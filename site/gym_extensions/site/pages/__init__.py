"""One module a kind of page, each with a ``PAGE``; being in this folder is what puts it on the site."""

"""One module per kind of page, each with a ``PAGE``. A module in this folder is a page of the site."""

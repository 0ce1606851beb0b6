"""Tables and lists with several pages: which rows are on which page, and their CSV."""

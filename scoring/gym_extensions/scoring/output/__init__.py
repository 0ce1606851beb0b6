"""What readers get: the screen, tables, CSV and Markdown, sentences, and the schemas of the documents."""

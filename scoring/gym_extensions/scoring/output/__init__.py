"""What readers get: the screen, frames, CSV and Markdown, sentences, and the schemas of the documents."""

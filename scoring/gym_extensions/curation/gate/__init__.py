"""The gate for pull requests: reads their files from git, and judges submissions in a limited process."""

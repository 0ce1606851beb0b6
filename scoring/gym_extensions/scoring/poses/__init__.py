"""The motion of audited episodes as small documents, which pages show. Loads no simulator."""

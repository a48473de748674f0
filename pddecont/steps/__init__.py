"""A run: what its file says, and one file a kind of step."""

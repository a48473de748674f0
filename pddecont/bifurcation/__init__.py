"""Special points of a branch, one kind a file: test function, defining equations, what happens there."""

"""Ways to discretise the delay, one a file, behind one interface (design section 5)."""

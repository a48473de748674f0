"""What is compiled when the package is built, and its sources."""

"""The integrator: plain Python that is compiled when the package is built."""

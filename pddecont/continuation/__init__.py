"""Solving and following systems of equations; knows residuals, Jacobians, tests and nothing of models or orbits."""

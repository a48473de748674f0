"""Meshes and differences that the tests of several ways to discretise the delay share."""

from __future__ import annotations

import math

import numpy as np

from pddecont.collocation import Mesh, equal_cuts
from tests.orbits import segment_pieces

# Two segments and a delay, and the frequency of one turn in their sum.
THETA = np.array([9.0, 1.3, 3.8])
LAG = np.array([0.0, 0.0, 1.0])
# No delays that vary.
NOTHING = np.zeros((0, 0))
OMEGA = 2 * math.pi / (THETA[0] + THETA[1])


def mesh_of(degree, counts):
    """Return a mesh of two segments with so many equal intervals each, on which theta has one delay."""
    return Mesh(degree, 2, segment_pieces(2, 3, equal_cuts(counts)))


def delayed(method, mesh, theta, values):
    """Return what a method reads at a mesh's equation points."""
    return method.operator(mesh, theta, LAG, mesh.equation_points).weights.apply(values)


def check_theta_derivative(method, mesh, tolerance):
    """Compare a method's derivatives in durations and delay with differences of the fourth order."""
    values = np.random.default_rng(0).normal(size=(mesh.n_base, 2))
    operator = method.operator(mesh, THETA, LAG, mesh.equation_points)
    exact = operator.theta_derivative(values, [0, 1, 2], 0)
    for k in range(3):
        step = 1e-3 * np.eye(3)[k]
        near = delayed(method, mesh, THETA + step, values) - delayed(method, mesh, THETA - step, values)
        far = delayed(method, mesh, THETA + 2 * step, values) - delayed(method, mesh, THETA - 2 * step, values)
        difference = (8 * near - far) / 12e-3
        assert np.max(np.abs(difference - exact[:, :, k])) < tolerance * max(1.0, np.max(np.abs(exact)))

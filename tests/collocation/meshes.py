"""Any meshes, for properties: segments, pieces cut anywhere, and the theta that moves them."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from pddecont.collocation import Mesh, Piece


def make_pieces(shape, n_delays=0):
    """Return pieces for ``shape``: for each segment the cuts of its pieces, pieces of equal length."""
    n = len(shape)
    pieces = []
    for s, inside in enumerate(shape):
        for j, cuts in enumerate(inside):
            start, end = np.zeros(n + n_delays), np.zeros(n + n_delays)
            start[:s] = end[:s] = 1.0
            start[s], end[s] = j / len(inside), (j + 1) / len(inside)
            pieces.append(Piece(s, start, end, np.asarray(cuts, dtype=float)))
    return tuple(pieces)


@st.composite
def cuts(draw):
    """Return the cuts of a piece: increasing fractions from 0 to 1."""
    shares = np.array(draw(st.lists(st.floats(0.05, 1.0), min_size=1, max_size=4)))
    inner = np.cumsum(shares)[:-1] / np.sum(shares)
    return np.concatenate([[0.0], inner, [1.0]])


@st.composite
def meshes(draw, degree=None):
    """Return a mesh and a theta of segment durations."""
    shape = draw(st.lists(st.lists(cuts(), min_size=1, max_size=2), min_size=1, max_size=3))
    theta = np.array(draw(st.lists(st.floats(0.1, 10.0), min_size=len(shape), max_size=len(shape))))
    chosen = draw(st.integers(1, 6)) if degree is None else degree
    return Mesh(chosen, len(shape), make_pieces(shape)), theta

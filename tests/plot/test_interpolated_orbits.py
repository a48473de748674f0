"""Recorded orbits between their base points."""

import numpy as np
import pytest

from pddecont.collocation.basis import make_basis
from pddecont.errors import ResultsError
from pddecont.plot.interpolated_orbits import PER_INTERVAL, interpolate_segments
from pddecont.results import Step


def recorded(degree, n_intervals, values, claimed=None):
    """Return a step with one orbit of two segments, polynomials of time on [0, 1] and [1, 3]."""
    edges = [np.linspace(0.0, 1.0, n_intervals + 1), np.linspace(1.0, 3.0, n_intervals + 1)]
    base = make_basis(degree).base
    times = [np.append((e[:-1, None] + base[:-1] * np.diff(e)[:, None]).ravel(), e[-1]) for e in edges]
    orbits = {
        "time": np.concatenate(times),
        "states": np.concatenate([values(t) for t in times]),
        "segment": np.repeat([0, 1], len(times[0])),
        "mesh": np.array([float(degree if claimed is None else claimed)]),
    }
    ends = {f"{name}_end": np.array([len(array)]) for name, array in orbits.items()}
    return Step("s", "orbit", {}, {}, orbits | ends, (), True)


@pytest.mark.parametrize("degree", [1, 2, 5, 20])
def test_polynomials_of_the_mesh_are_drawn_as_they_are(degree):
    def values(t):
        return np.column_stack([t**degree, 1.0 - t])

    arcs = interpolate_segments(recorded(degree, 3, values), 0)
    for (times, states), (start, end) in zip(arcs, [(0.0, 1.0), (1.0, 3.0)], strict=True):
        assert len(times) == 3 * PER_INTERVAL + 1
        assert (times[0], times[-1]) == (start, end)
        assert np.all(np.diff(times) > 0)
        assert states == pytest.approx(values(times), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("claimed", [-1, 0, 21, 1e9])
def test_a_mesh_that_claims_a_strange_degree_is_refused(claimed):
    with pytest.raises(ResultsError, match="does not go with 16 base points"):
        interpolate_segments(recorded(5, 3, lambda t: t[:, None], claimed), 0)

"""Places in the vector of unknowns."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.orbit.unknowns import Unknowns
from tests.collocation.meshes import meshes


@settings(max_examples=40, deadline=None, derandomize=True)
@given(meshes(), st.integers(1, 3), st.booleans(), st.integers(0, 2), st.integers(0, 1000))
def test_parts_join_to_a_vector_and_come_back(found, n_states, forced, n_free, seed):
    mesh, durations = found
    unknowns, rng = Unknowns(mesh, n_states, forced, n_free), np.random.default_rng(seed)
    values, start, free = rng.normal(size=(mesh.n_base, n_states)), 0.3 if forced else 0.0, rng.normal(size=n_free)
    x = unknowns.join(values, durations, start, free)
    assert x.shape == (unknowns.size,)
    assert unknowns.size == mesh.n_base * n_states + mesh.n_segments + forced + n_free
    back = unknowns.split(x)
    for part, own in zip(back, (values, durations, start, free), strict=True):
        assert np.array_equal(part, own)
    assert np.array_equal(x[unknowns.value_index], values)
    assert [x[unknowns.duration(s)] for s in range(mesh.n_segments)] == durations.tolist()
    # The parts lie one after another, without a gap.
    parts = (unknowns.values, unknowns.durations, unknowns.start, unknowns.free)
    assert np.array_equal(np.concatenate([np.arange(len(x))[part] for part in parts]), np.arange(len(x)))

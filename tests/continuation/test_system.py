"""A system without a mesh passes for one with a mesh that never changes."""

import numpy as np

from pddecont.continuation import FixedUnknowns
from tests.continuation.systems import circle


def test_a_system_without_a_mesh_keeps_its_unknowns():
    bare = circle(scale=(2.0, 3.0))
    system = FixedUnknowns(bare)
    x, other = np.array([0.8, 0.6]), np.array([1.0, 2.0])
    at = system.at(x)
    assert np.array_equal(at.residual, bare.at(x).residual) and np.array_equal(at.jacobian(), bare.at(x).jacobian())
    assert np.array_equal(system.scaling.scale, [2.0, 3.0])
    assert np.array_equal(system.mesh_independent_index, [0, 1])
    assert system.mesh_is_valid(at) and system.mesh_is_adequate(at)
    for solved in (False, True):
        same, moved, others = system.remesh(at, [other], solved=solved)
        assert same is system and moved is at.x and others == [other]
    assert system.interpolate_from(FixedUnknowns(bare), other) is other
    assert system.update_reference(at) is system
    assert system.explain_unsettled_mesh() == ""

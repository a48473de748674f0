"""Places of entries, found once: whom they serve, and that they give what they gave."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from pddecont.collocation import MeshRule
from pddecont.delay import Chain
from pddecont.orbit import Orbit, adapt_mesh
from pddecont.orbit.jacobian import JacobianAssembler, assemble_periodic
from tests.known_orbits import hard_wall, impact_oscillator, mackey_glass
from tests.orbit.exact import circle

RULE = MeshRule(4, intervals=8)


@pytest.mark.parametrize("orbit", [impact_oscillator, hard_wall, mackey_glass], ids=lambda f: f.__name__)
def test_an_assembly_serves_orbits_with_the_same_reads(orbit):
    """Another orbit on the mesh: the entries in the old places are those of an assembly of its own."""
    first = adapt_mesh(orbit(), RULE).with_free((next(iter(orbit().numeric.model.parameters)),))
    assembly = assemble_periodic(first.problem, first.equation_reads)
    moved = Orbit(first.problem, first.x * (1 + 1e-3 * np.sin(np.arange(len(first.x)))))
    reads = moved.equation_reads
    assert assembly.reads_as(reads)
    exact = JacobianAssembler().make_jacobian(moved).toarray()
    assert assembly.make_matrix(moved, reads).toarray() == pytest.approx(exact, abs=1e-12 * np.max(np.abs(exact)))


def test_whom_it_serves():
    orbit = adapt_mesh(impact_oscillator(), RULE)
    problem, reads = orbit.problem, orbit.equation_reads
    assembly = assemble_periodic(problem, reads)
    assert assembly.serves(problem, reads)
    assert assembly.serves(replace(problem, parameters=problem.parameters * 1.1), reads)
    assert not assembly.serves(replace(problem, free=("K",)), reads)
    other = adapt_mesh(orbit, RULE)
    assert not assembly.serves(other.problem, other.equation_reads)
    # A delay so long that other intervals are read stands in other places.
    far = circle(tau=4.0).equation_reads
    near = assemble_periodic(circle().problem, circle().equation_reads)
    assert not near.reads_as(far)


def test_a_full_delay_operator_makes_a_full_matrix():
    orbit = circle(method=Chain(2, 4), rule=RULE)
    assembly = assemble_periodic(orbit.problem, orbit.equation_reads)
    assert assembly.has_full_reads
    matrix = assembly.make_matrix(orbit, orbit.equation_reads)
    assert not sp.issparse(matrix)
    # The rest of it is the sparse part: what the model gives without its delayed values.
    values = assembly.evaluate(assembly.linearise(orbit, orbit.equation_reads))
    part = assembly.pattern.fill(values).toarray()
    assert np.any(matrix != part)
    again = part.copy()
    assembly.add_full_reads(again, assembly.linearise(orbit, orbit.equation_reads))
    assert np.array_equal(again, matrix)
    sparse = assemble_periodic(circle().problem, circle().equation_reads)
    assert not sparse.has_full_reads
    assert not assembly.reads_as(circle(rule=RULE).equation_reads)

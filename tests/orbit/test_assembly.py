"""Places of entries, found once: whom they serve, and that they give what they gave."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from pddecont.collocation import MeshRule
from pddecont.delay import Chain
from pddecont.orbit import Orbit, adapt_mesh, transfer_orbit
from pddecont.orbit.assembly import Assembly, find_assembly
from pddecont.orbit.jacobian import PeriodicColumns, make_jacobian
from tests.known_orbits import hard_wall, impact_oscillator, mackey_glass
from tests.orbit.exact import circle

RULE = MeshRule(4, intervals=8)


def assemble_periodic(problem, reads):
    """Return the places of a Jacobian's entries, found for this problem alone."""
    return Assembly(problem, reads, PeriodicColumns(problem))


def find(problem, reads):
    """Return the places of a Jacobian's entries, those of an earlier one where they serve."""
    return find_assembly("here", problem, reads, lambda: PeriodicColumns(problem))


@pytest.mark.parametrize("orbit", [impact_oscillator, hard_wall, mackey_glass], ids=lambda f: f.__name__)
def test_an_assembly_serves_orbits_with_the_same_reads(orbit):
    """Another orbit on the mesh: the entries in the old places are those of an assembly of its own."""
    first = adapt_mesh(orbit(), RULE).with_free((next(iter(orbit().numeric.model.parameters)),))
    assembly = assemble_periodic(first.problem, first.equation_reads)
    moved = Orbit(first.problem, first.x * (1 + 1e-3 * np.sin(np.arange(len(first.x)))))
    reads = moved.equation_reads
    assert assembly.reads_as(reads)
    exact = make_jacobian(moved).toarray()
    assert assembly.make_matrix(moved, reads).toarray() == pytest.approx(exact, abs=1e-12 * np.max(np.abs(exact)))


def test_whom_it_serves():
    orbit = adapt_mesh(impact_oscillator(), RULE)
    problem, reads = orbit.problem, orbit.equation_reads
    assembly = assemble_periodic(problem, reads)
    assert assembly.reads_as(reads)
    found = find(problem, reads)
    assert found is not assembly
    assert find(problem, reads) is found
    assert find(replace(problem, parameters=problem.parameters * 1.1), reads) is found
    assert find(replace(problem, free=("K",)), reads) is not found
    other = adapt_mesh(orbit, RULE)
    assert find(other.problem, other.equation_reads) is not found
    # A delay so long that other intervals are read stands in other places.
    far = circle(tau=4.0).equation_reads
    near = assemble_periodic(circle().problem, circle().equation_reads)
    assert not near.reads_as(far)


def test_reads_move_to_other_places():
    """A mesh made for another delay: entries where an assembly of its own has them, for it and for one moved there."""
    orbit = circle(tau=1.1)
    first = assemble_periodic(orbit.problem, orbit.equation_reads)
    far = circle(tau=1.4)
    mesh = orbit.mesh.anchor(far.theta)
    there = Orbit(replace(far.problem, mesh=mesh), orbit.x)
    own, moved = (
        assemble_periodic(there.problem, there.equation_reads),
        first.move_to(there.problem, there.equation_reads, lambda: PeriodicColumns(there.problem)),
    )
    assert not first.reads_as(there.equation_reads)
    assert moved.reads_as(there.equation_reads)
    assert np.array_equal(moved.entry_rows, own.entry_rows)
    assert np.array_equal(moved.entry_columns, own.entry_columns)
    exact = own.make_matrix(there, there.equation_reads).toarray()
    assert np.array_equal(moved.make_matrix(there, there.equation_reads).toarray(), exact)


@pytest.mark.parametrize("orbit", [impact_oscillator, hard_wall, mackey_glass], ids=lambda f: f.__name__)
def test_places_move_to_other_meshes_of_one_layout(orbit):
    """Intervals cut elsewhere: places and entries are those of an assembly of that mesh's own."""
    first = adapt_mesh(orbit(), RULE)
    pieces = tuple(replace(p, cuts=p.cuts**1.1) for p in first.mesh.pieces)
    mesh = replace(first.mesh, pieces=pieces)
    mesh.take_layout(first.mesh)
    there = transfer_orbit(first, mesh)
    old, moved = (find(o.problem, o.equation_reads) for o in (first, there))
    own = assemble_periodic(there.problem, there.equation_reads)
    assert moved.entry_rows is old.entry_rows
    assert np.array_equal(moved.entry_rows, own.entry_rows)
    assert np.array_equal(moved.entry_columns, own.entry_columns)
    exact = own.make_matrix(there, there.equation_reads).toarray()
    assert np.array_equal(moved.make_matrix(there, there.equation_reads).toarray(), exact)
    # And what is found for the first one stands as it was.
    assert np.array_equal(find(first.problem, first.equation_reads).entry_columns, old.entry_columns)


def test_delays_may_be_read_in_other_ways_on_meshes_of_one_layout():
    """From the orbit itself, by stages, from the orbit: each matrix is that of a mesh which shares nothing."""
    chained, direct = circle(method=Chain(2, 4), rule=RULE), circle(rule=RULE)
    for method in (direct.problem.delay, chained.problem.delay, direct.problem.delay):
        orbit = Orbit(replace(direct.problem, delay=method), direct.x)
        mesh = replace(direct.mesh, pieces=tuple(replace(p, cuts=p.cuts**1.05) for p in direct.mesh.pieces))
        alone = transfer_orbit(orbit, replace(mesh))
        mesh.take_layout(direct.mesh)
        moved = transfer_orbit(orbit, mesh)
        exact = make_jacobian(alone)
        found = make_jacobian(moved)
        assert sp.issparse(found) == (method == direct.problem.delay)
        assert np.array_equal(*(m.toarray() if sp.issparse(m) else m for m in (found, exact)))


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

"""Orbits and meshes as arrays, and back: nothing is lost, and arrays that are none are refused."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.collocation import MAX_DEGREE
from pddecont.errors import PddecontError
from pddecont.orbit import orbit_from_rows, orbit_to_rows
from pddecont.orbit.serialise import mesh_from_row, mesh_to_row, read_segments
from tests.collocation.meshes import meshes
from tests.conftest import shipped
from tests.known_orbits import hard_wall, impact_oscillator, mackey_glass, neuron
from tests.orbit.exact import circle

ORBITS = [impact_oscillator, hard_wall, mackey_glass, neuron, circle]


def there_and_back(orbit, rows=None):
    problem = orbit.problem
    rows = orbit_to_rows(orbit) if rows is None else rows
    return orbit_from_rows(
        orbit.numeric, problem.delay, orbit.parameters, problem.free, rows, problem.n_periods, problem.phase
    )


@settings(max_examples=40, deadline=None, derandomize=True)
@given(found=meshes(), made_for=st.booleans())
def test_meshes_come_back_as_they_were(found, made_for):
    mesh, theta = found
    mesh = replace(mesh, reference_theta=theta if made_for else None)
    back = mesh_from_row(mesh_to_row(mesh))
    assert (back.degree, back.n_segments) == (mesh.degree, mesh.n_segments)
    assert np.array_equal(back.start, mesh.start)
    assert np.array_equal(back.length, mesh.length)
    assert np.array_equal(back.segment, mesh.segment)
    assert np.array_equal(back.piece, mesh.piece)
    assert (back.reference_theta is None) == (not made_for)
    assert not made_for or np.array_equal(back.reference_theta, theta)


@pytest.mark.parametrize("make", ORBITS, ids=lambda f: f.__name__)
@pytest.mark.parametrize("n_free", [0, 2])
def test_orbits_come_back_as_they_were(make, n_free):
    orbit = make()
    orbit = orbit.with_free(tuple(orbit.numeric.model.parameters)[:n_free])
    back = there_and_back(orbit)
    assert np.array_equal(back.x, orbit.x)
    assert back.signature.names == orbit.signature.names
    assert back.problem.links == orbit.problem.links
    assert np.array_equal(back.parameters, orbit.parameters)
    assert np.array_equal(back.equation_reads.xd, orbit.equation_reads.xd)
    needs = orbit.signature.needs_phase_reference
    assert np.array_equal(back.problem.reference, orbit.values) if needs else back.problem.reference is None


def test_rows_of_base_points():
    orbit = impact_oscillator()
    rows = orbit_to_rows(orbit, np.array([1.0, 2.0]))
    mesh = orbit.mesh
    assert rows["time"][mesh.first_base] == pytest.approx(orbit.start + orbit.event_times[:-1])
    assert rows["segment"][mesh.last_base].tolist() == [0.0, 1.0]
    assert len(rows["time"]) == len(rows["segment"]) == mesh.n_base
    assert rows["unknowns"] == pytest.approx([*orbit.durations, orbit.start])
    assert rows["signature"].tobytes() == b"NC C"
    assert rows["tangent"].tolist() == [1.0, 2.0]
    assert len(orbit_to_rows(orbit)["tangent"]) == 0


@pytest.mark.parametrize(
    ("place", "value"), [(0, MAX_DEGREE + 1), *((place, value) for place in range(4) for value in (-1, 0, 1e6))]
)
def test_a_row_that_is_no_mesh_is_refused(place, value):
    """A count that the row cannot hold."""
    row = mesh_to_row(impact_oscillator().mesh)
    row[place] = value
    with pytest.raises(ValueError, match="not that of a mesh"):
        mesh_from_row(row)


def test_a_row_cut_off_is_refused():
    row = mesh_to_row(impact_oscillator().mesh)
    with pytest.raises(ValueError, match="not that of a mesh"):
        mesh_from_row(row[: len(row) // 2])


@pytest.mark.parametrize(("place", "value"), [(0, np.nan), (0, -1.0), (2, np.inf)])
def test_unknowns_that_are_none_are_refused(place, value):
    orbit = impact_oscillator()
    rows = orbit_to_rows(orbit)
    rows["unknowns"] = rows["unknowns"].copy()
    rows["unknowns"][place] = value
    with pytest.raises(ValueError, match="not finite, or a segment ends before it begins"):
        there_and_back(orbit, rows)


def test_segments_by_name():
    model = shipped("impact_oscillator").model
    assert [s.name for s in read_segments(model, "NC C NC")] == ["NC", "C", "NC"]
    (free,) = read_segments(model, "(NC)")
    assert (free.name, free.mode, free.event) == ("(NC)", "NC", "")
    with pytest.raises(PddecontError, match="runs through segment 'D', which this model does not have"):
        read_segments(model, "NC D")

"""Where the equations of an orbit stand in the order of time."""

from __future__ import annotations

import numpy as np

from pddecont.continuation import TimeOrder
from pddecont.orbit.problem import OrbitProblem
from pddecont.orbit.residual import Rows

# Unknowns of a mesh interval beyond which its own block is better kept sparse.
LARGEST_BLOCK = 64


def order_in_time(problem: OrbitProblem, *, goes_on: bool = False) -> TimeOrder | None:
    """Return the blocks of one period's equations, bordered to be square; None where they are large.

    First stands the state that the period begins with, then interval after interval, and between segments the resets.
    An orbit comes back to where it began; where the motion ``goes_on`` the state after the period has unknowns and
    equations of its own, behind all others.
    """
    mesh, unknowns, n = problem.mesh, problem.unknowns, problem.unknowns.n_states
    rows, inside = Rows(unknowns), mesh.degree * n
    if inside > LARGEST_BLOCK:
        return None

    def find() -> TimeOrder:
        resets, starts = rows.resets + n * np.arange(mesh.n_segments), unknowns.value_index[mesh.first_base, 0]
        # The reset at a segment's end makes the start of the next one, the last one's what the period begins with.
        made, makes = np.append(starts[1:], starts[:1]), np.append(mesh.last_interval[:-1], -1)
        if goes_on:
            resets, made = np.append(resets, rows.size), np.concatenate([starts[1:], [unknowns.size], starts[:1]])
            makes = np.append(mesh.last_interval, -1)
        when = np.argsort(np.concatenate([np.arange(mesh.n_intervals), makes + 0.5]))
        first = np.concatenate([inside * np.arange(mesh.n_intervals), resets])
        columns = np.concatenate([unknowns.value_index[mesh.base_index[:, 1], 0], made])
        sizes = np.repeat([inside, n], [mesh.n_intervals, len(resets)])
        return TimeOrder(first[when], columns[when], sizes[when], unknowns.size + n * goes_on)

    return mesh.alike(("order in time", unknowns.forced, unknowns.n_free, goes_on), find)

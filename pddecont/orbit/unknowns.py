"""The unknowns of a periodic orbit by name."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import Mesh
from pddecont.memo import cached_property

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Unknowns:
    """Places in the vector of unknowns: base values (base point by base point), durations, breaking times, start, free.

    ``start`` is the time t_0 at which the first segment begins; autonomous models have none. ``free`` are the free
    parameters.
    """

    mesh: Mesh
    n_states: int
    forced: bool
    n_free: int

    @cached_property
    def values(self) -> slice:
        """Base-point values, n_base * n_states of them."""
        return slice(0, self.mesh.n_base * self.n_states)

    @cached_property
    def durations(self) -> slice:
        """Segment durations T_1 .. T_S."""
        return slice(self.values.stop, self.values.stop + self.mesh.n_segments)

    @cached_property
    def breaking(self) -> slice:
        """Breaking times of delays that vary b_1 .. b_J."""
        return slice(self.durations.stop, self.durations.stop + self.mesh.n_breaking)

    @cached_property
    def moving(self) -> slice:
        """All times that mesh edges move with: durations and breaking times."""
        return slice(self.durations.start, self.breaking.stop)

    @cached_property
    def start(self) -> slice:
        """Start time t_0 of a forced orbit (empty for an autonomous one)."""
        return slice(self.breaking.stop, self.breaking.stop + self.forced)

    @cached_property
    def free(self) -> slice:
        """Free parameters."""
        return slice(self.start.stop, self.start.stop + self.n_free)

    @cached_property
    def size(self) -> int:
        """Number of unknowns."""
        return int(self.free.stop)

    @cached_property
    def mesh_independent(self) -> NDArray[np.intp]:
        """Places of durations, start and free parameters."""
        return np.concatenate([np.arange(*self.durations.indices(self.size)), np.arange(self.start.start, self.size)])

    @cached_property
    def value_index(self) -> NDArray[np.intp]:
        """Place of each base value, shape (n_base, n_states)."""
        return np.arange(self.values.stop).reshape(self.mesh.n_base, self.n_states)

    def duration(self, s: int) -> int:
        """Return the place of the duration of segment ``s``."""
        return int(self.durations.start) + s

    def split(self, x: Array) -> tuple[Array, Array, float, Array]:
        """Return base values (n_base, n_states), durations (S,), t_0 (0 if autonomous) and free parameters."""
        values = x[self.values].reshape(self.mesh.n_base, self.n_states)
        start = float(x[self.start][0]) if self.forced else 0.0
        return values, x[self.durations], start, x[self.free]

    def join(self, values: Array, durations: Array, start: float, free: Array, breaking: Array | None = None) -> Array:
        """Return the vector of unknowns; inverse of :meth:`split`.

        Breaking times are by default those that the mesh was made for.
        """
        if breaking is None:
            breaking = self.mesh.reference_breaking
        return np.concatenate([np.ravel(values), durations, breaking, [start] if self.forced else [], free])

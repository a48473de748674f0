"""An orbit where its segments begin."""

from __future__ import annotations

import numpy as np

from pddecont.collocation import MeshPoints
from pddecont.orbit.orbit import Orbit, Reads


def read_starts(orbit: Orbit) -> Reads:
    """Return what an orbit is where each of its segments begins, after the reset."""

    def find() -> Reads:
        mesh, times = orbit.mesh, orbit.event_times
        if np.all(mesh.evaluate_edges(orbit.theta)[1][mesh.first_interval] > 0.0):
            return orbit.read(mesh.alike("starts", lambda: mesh.grid(np.zeros(1), mesh.first_interval)))
        found = [mesh.locate(orbit.theta, times[[s]], segment=s)[0] for s in range(len(orbit.signature))]
        interval = np.concatenate([points.interval for points in found])
        return orbit.read(MeshPoints(interval, np.concatenate([points.sigma for points in found])))

    return orbit.once("starts", find)

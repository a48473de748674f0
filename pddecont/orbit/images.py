"""The ways in which one periodic orbit can be written: from which of its segments, and from which moment, it begins."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.collocation import MeshPoints
from pddecont.orbit.orbit import Orbit

Array = NDArray[np.float64]
# Steps of Newton's method for the moment at which an orbit is nearest to a state; it begins at the nearest base point.
N_STEPS = 4


def list_images(orbit: Orbit, like: Orbit) -> list[Array]:
    """Return the mesh-independent unknowns of an orbit in each way in which ``like`` may write it.

    These are the states at the segments' starts, durations, the start of a forced orbit, and free parameters. With
    events an orbit begins at any of its segments that has the signature of ``like``; without, a forced one at any of
    its forcing periods, and an autonomous one at the moment at which it is nearest to the start of ``like``.
    """
    if len(orbit.signature) != len(like.signature) or orbit.problem.n_periods != like.problem.n_periods:
        return []
    forced = orbit.numeric.model.forced
    if not orbit.signature.has_events:
        if orbit.signature.names != like.signature.names:
            return []
        k = orbit.problem.n_periods
        times = orbit.period * np.arange(k) / k if forced else _find_nearest(orbit, like)
        start = [orbit.start] if forced else []
        return [np.concatenate([_read(orbit, t), orbit.durations, start, orbit.free]) for t in times]
    names, images = orbit.signature.names, []
    starts, unit = orbit.values[orbit.mesh.first_base], orbit.period / orbit.problem.n_periods
    for s in range(len(names)):
        if [*names[s:], *names[:s]] != like.signature.names:
            continue
        begin, following = orbit.start + orbit.event_times[s], [*range(s, len(names)), *range(s)]
        begin += unit * np.round((like.start - begin) / unit)
        images.append(
            np.concatenate(
                [starts[following].ravel(), orbit.durations[following], [begin] if forced else [], orbit.free]
            )
        )
    return images


def _read(orbit: Orbit, time: float) -> Array:
    points, _ = orbit.mesh.locate(orbit.theta, np.array([time]))
    return np.asarray(orbit.mesh.interpolate(orbit.values, points)[0])


def _find_nearest(orbit: Orbit, like: Orbit) -> Array:
    """Return the time (1,) from its start at which an autonomous orbit is nearest to where ``like`` starts."""
    mesh, theta = orbit.mesh, orbit.theta
    target, size = like.values[0], np.maximum(np.ptp(orbit.values, axis=0), np.finfo(float).tiny)
    best = int(np.argmin(np.sum(((orbit.values - target) / size) ** 2, axis=1)))
    time = float(mesh.base_times(theta)[best])
    for _ in range(N_STEPS):
        points, _ = mesh.locate(theta, np.array([time]))
        away = (mesh.interpolate(orbit.values, points)[0] - target) / size
        slope = _slope(orbit, points) / size
        time -= float(away @ slope) / max(float(slope @ slope), np.finfo(float).tiny)
    return np.array([time])


def _slope(orbit: Orbit, points: MeshPoints) -> Array:
    """Return the rate of the states (n_states,) at one point of the mesh."""
    mesh = orbit.mesh
    weights = mesh.basis.lagrange(points.sigma) @ mesh.basis.differentiate
    length = (mesh.length @ orbit.theta)[points.interval]
    return np.asarray(weights[0] @ orbit.values[mesh.base_index[points.interval[0]]] / length[0])

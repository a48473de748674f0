"""Period doubling (PD): a multiplier is -1.

The eigenvector of -1 alternates from period to period, so the orbit taken twice plus and minus a little of it is a first guess of the
doubled orbit. The other way round, a branch of doubled orbits meets the single one where its two halves become equal.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation.conditioned import solve_special
from pddecont.continuation.arclength import Metric, tangent
from pddecont.continuation.locate import Located
from pddecont.errors import ConvergenceError
from pddecont.orbit.curve import Curve, settle
from pddecont.orbit.mesh import Places
from pddecont.orbit.meshing import MeshRule
from pddecont.orbit.problem import OrbitProblem
from pddecont.orbit.reshape import Part, reshape, sampled
from pddecont.stability.multipliers import Known, Multipliers, eigenvector

Array = NDArray[np.float64]
KIND = "PD"
EQUAL = 1e-5
NEAR = 0.3
OPPOSITE = 0.8
FAR = 3.0


def passing(m: Multipliers) -> float:
    """Return the distance to -1 of the real multiplier nearest to it, with the sign of the parity of those beyond."""
    real = m.own[m.own.imag == 0.0].real
    if not len(real):
        return float("nan")
    return float((-1.0) ** np.sum(real < -1.0) * np.min(np.abs(real + 1.0)))


@dataclass(frozen=True, eq=False)
class Doubling:
    """The condition that a multiplier is -1: the product of 1 + mu over the ``n`` nearest to it is zero.

    More than one are taken where several are near, so that the condition stays smooth when they meet.
    """

    known: Known
    n: int = 1
    kind: str = KIND

    def value(self, curve: Curve, x: Array) -> float:
        """Return the product at the orbit ``x``."""
        own = self.known(curve.problem, x).own
        nearest = own[np.argsort(np.abs(own + 1.0))][: self.n]
        return float(np.prod(1.0 + nearest).real) if len(nearest) else float("nan")

    def framed(self, curve: Curve, x: Array) -> Doubling:
        """Return the same condition over the multipliers that are near -1 at ``x``."""
        return replace(self, n=max(1, int(np.sum(np.abs(self.known(curve.problem, x).own + 1.0) < NEAR))))


def doubled(problem: OrbitProblem, x: Array, rule: MeshRule) -> tuple[OrbitProblem, Array, Array]:
    """Return the orbit ``x`` taken twice as a problem, its unknowns, and the direction in which the doubled orbits leave it."""
    bare, x = problem.with_free(x, ())
    durations = bare.layout.split(x)[1]
    ends = np.concatenate([[0.0], np.cumsum(durations)])
    period = ends[-1]
    parts = [Part(segment, k * period + ends[s], k * period + ends[s + 1]) for k in (0, 1) for s, segment in enumerate(bare.segments)]
    if not bare.segments[0].event:
        parts = [Part(bare.segments[0], 0.0, 2 * period)]
    twice, guess = reshape(bare, x, parts, rule, 2 * bare.n_periods)
    values, own, start, _ = bare.layout.split(eigenvector(bare, x, -1.0))
    direction = np.zeros(twice.layout.size)
    sign = np.where(twice.mesh.base_times(twice.theta(guess)) < period * (1.0 - 1e-12), 1.0, -1.0)
    if len(parts) > 1:
        sign = np.repeat([1.0, -1.0], [twice.mesh.first_base[len(durations)], twice.mesh.n_base - twice.mesh.first_base[len(durations)]])
        direction[twice.layout.durations] = np.concatenate([own, -own])
    direction[twice.layout.values] = (sign[:, None] * sampled(bare, x, values, parts, twice, guess)).ravel()
    direction[twice.layout.start] = start
    return twice, guess, direction


def halves(problem: OrbitProblem, x: Array, metric: Metric) -> Array:
    """Return what differs between an orbit's two halves, relative to its size: zero on a single orbit, empty if it is not doubled."""
    values, durations, _, _ = problem.layout.split(x)
    sizes, period = metric.scale[problem.layout.value_index[0]], metric.scale[problem.layout.durations.start]
    names = [s.name for s in problem.segments]
    half = len(names) // 2
    if not problem.segments[0].event:
        if problem.numeric.model.forced and problem.n_periods % 2:
            return np.zeros(0)
        theta = problem.theta(x)
        edges, lengths = problem.mesh.start @ theta, problem.mesh.length @ theta
        at = np.sum(durations) * np.array([0.0, 0.25, 0.5, 0.75])
        interval = np.searchsorted(edges, at, side="right") - 1
        z = problem.mesh.at(values, Places(interval, (at - edges[interval]) / lengths[interval]))
        return ((z[:2] - z[2:]) / sizes).ravel()
    if len(names) % 2 or names[:half] != names[half:] or (problem.numeric.model.forced and problem.n_periods % 2):
        return np.zeros(0)
    starts = values[problem.mesh.first_base]
    return np.concatenate([(durations[:half] - durations[half:]) / period, ((starts[:half] - starts[half:]) / sizes).ravel()])


def equal_halves(problem: OrbitProblem, x: Array, metric: Metric) -> bool:
    """Whether the orbit ``x`` is a single one taken twice."""
    difference = halves(problem, x, metric)
    return len(difference) > 0 and float(np.max(np.abs(difference))) < EQUAL


def halved(problem: OrbitProblem, x: Array, rule: MeshRule) -> tuple[OrbitProblem, Array]:
    """Return the mean of an orbit's two halves as an orbit of its own, as a guess."""
    bare, x = problem.with_free(x, ())
    values, durations, start, _ = bare.layout.split(x)
    ends = np.concatenate([[0.0], np.cumsum(durations)])
    half = len(bare.segments) // 2
    if not bare.segments[0].event:
        first, second = ([Part(bare.segments[0], k * ends[-1] / 2, (k + 1) * ends[-1] / 2)] for k in (0, 1))
    else:
        first, second = ([Part(bare.segments[s], ends[s], ends[s + 1]) for s in range(k * half, (k + 1) * half)] for k in (0, 1))
    single, guess = reshape(bare, x, first, rule, max(1, bare.n_periods // 2))
    layout = single.layout
    one, other = (sampled(bare, x, values, parts, single, guess) for parts in (first, second))
    guess[layout.values] = 0.5 * (one + other).ravel()
    if bare.segments[0].event:
        guess[layout.durations] = 0.5 * (durations[:half] + durations[half:])
        # The second half begins half of all forcing periods later, but for what differs.
        guess[layout.start] = start + 0.5 * (ends[half] - 0.5 * ends[-1])
    if single.reference is not None:
        single = replace(single, reference=layout.split(guess)[0])
    return single, guess


def collapsed(a: Located, b: Located, rule: MeshRule, known: Known) -> Located | None:
    """Return the single orbit with the multiplier -1 onto which a branch of doubled orbits falls between ``a`` and ``b``.

    None if it does not: there all that differs between the halves of ``a`` differs the other way in ``b``, or no longer.
    """
    curve, x = a.problem, a.x
    before, after = halves(curve.problem, x, curve.metric()), halves(b.problem.problem, b.x, b.problem.metric())
    least = b if np.linalg.norm(after) < np.linalg.norm(before) else a
    fallen = float(np.max(np.abs(after))) < EQUAL
    if not fallen and before @ after > -OPPOSITE * np.linalg.norm(before) * np.linalg.norm(after):
        return None
    try:
        problem, solution = settle(*halved(least.problem.problem, least.x, rule), rule)
        problem, guess = problem.with_free(solution.x, curve.problem.free)
        single = Curve(problem, curve.sizes, rule)
        special, solution = solve_special(single, guess, Doubling(known))
    except ConvergenceError:
        return None
    scale = special.metric().scale[special.outline_index()]
    if np.max(np.abs(special.outline(solution.x) - single.outline(guess)) / scale) > FAR * float(np.max(np.abs(before))) + EQUAL:
        return None
    towards = np.zeros(len(solution.x))
    towards[special.problem.layout.free.start] = 1.0
    return Located(special.curve, solution.x, solution, tangent(special.curve, solution.x, special.metric(), towards))

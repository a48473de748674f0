"""Where a sweep's attractors are not on a branch that claims to be stable there, and why."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from tests.random_models.recorded import read_orbit

# An attractor is on a branch where its turn and its return lie between those of neighbouring rows, with so much to
# spare, in parts of their difference and of the orbit's sizes.
BETWEEN, SPARE = 0.6, 3e-3
CONTRADICTION = "on a part called unstable or no motion"


def explain_attractors(model, sweep, branch):
    """Return the sweep's attractors counted by where they are, and the contradictions among them.

    They are on a stable part of the branch, or something says why not. An attractor on a part of the branch that is
    called unstable, or no motion, is a contradiction: (where, what was said, what is true).
    """
    column = list(sweep.meta["parameters"]).index(model.free)
    places, counts, contradictions = {}, Counter(), []
    for row in range(len(sweep)):
        value = float(sweep.points["parameters"][row, column])
        kind, why = _explain(model, sweep, row, value, branch, column, places)
        counts[kind] += 1
        if kind == CONTRADICTION:
            contradictions.append(
                (f"sweep row {row}, {model.free} = {value:.8g}", why, "the swept motion settles there")
            )
    return counts, contradictions


def _explain(model, sweep, row, value, branch, column, places):
    """Return the kind of an attractor, and words on it."""
    if sweep.kind_of(row) == "":
        return f"motion failed: {sweep.reason(row).code}", ""
    if sweep.points["period"][row] == 0:
        return "no period", ""
    values = branch.points["parameters"][:, column]
    if not values.min() <= value <= values.max():
        ends = sorted({str(e.values.get("detail") or e.code) for e in branch.endings})
        return f"branch ended before: {', '.join(ends)}", ""
    counts = dict(zip(sweep.meta["segments"], sweep.points["n_segments"][row], strict=False))
    near, other, beside = [], False, []
    order = branch.order
    for i, j in pairwise(order):
        if not min(values[i], values[j]) <= value <= max(values[i], values[j]):
            continue
        a, b = (places.setdefault(k, _Return(model, branch, k)) for k in (i, j))
        same = [p for p in (a, b) if p.counts == {k: int(n) for k, n in counts.items() if n}]
        other |= not same
        beside += [branch.points["stable"][k] == 1 and branch.points["admissible"][k] == 1 for k in (i, j)]
        if same and _lies_between(a, b, sweep, row):
            near += [i, j]
    if not near:
        factor = sweep.points["turn"][row] / np.median([places[k].period for k in places]) if places else 0
        if round(factor) > 1 and abs(factor - round(factor)) < 0.05:
            kind = "several periods of the branch"
        else:
            kind = "another signature" if other else "another orbit of the same signature"
        return f"{kind}, beside {'a stable' if any(beside) else 'an unstable'} part of it", ""
    stable = [bool(branch.points["stable"][k] == 1) and bool(branch.points["admissible"][k]) for k in near]
    if any(stable):
        return "on a stable part of the branch", ""
    special = [branch.kind_of(k) for k in near if branch.kind_of(k)]
    if special:
        return "next to a special point", ""
    admissible = any(branch.points["admissible"][k] for k in near)
    said = "unstable" if admissible else "no motion of the model"
    return CONTRADICTION, f"rows {near}: {said}"


class _Return:
    """An orbit of a branch where a sweep would see it: at phase 0 of the forcing, or after the section's event."""

    def __init__(self, model, branch, row):
        orbit = read_orbit(branch, row)
        self.period, self.sizes = orbit.period, orbit.sizes
        self.counts = {} if orbit.eventless else dict(Counter(orbit.names))
        if model.section is None:
            forcing = model.evaluate(model.period, orbit.parameters)
            n = round(orbit.period / forcing)
            self.states = np.array([orbit(k * forcing, 1) for k in range(n)])
        elif "zero" in model.section:
            times = _upward_zeros(orbit, model.states.index(model.section["zero"]))
            self.states = np.array([orbit(t) for t in times]).reshape(-1, len(model.states))
        else:
            event = model.section["event"]
            met = [not orbit.eventless and model.segments[s].event == event for s in orbit.names]
            self.states = np.array([orbit(t, 1) for t in orbit.ends[met]]).reshape(-1, len(model.states))


def _upward_zeros(orbit, state):
    """Return the times in a period at which a state passes zero upwards."""
    t = np.linspace(orbit.start, orbit.start + orbit.period, 400)
    values = np.array([orbit(s)[state] for s in t])
    places = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
    return [brentq(lambda s: orbit(s)[state], t[i], t[i + 1]) for i in places]


def _lies_between(a, b, sweep, row):
    """Return whether an attractor's turn and its returns lie between those of two orbits, in any order of returns."""
    turn, returns = sweep.points["turn"][row], sweep.orbit(row)["returns"]
    low, high = sorted([a.period, b.period])
    if not low - BETWEEN * (high - low) - SPARE * low <= turn <= high + BETWEEN * (high - low) + SPARE * low:
        return False
    if a.states.shape != b.states.shape or len(a.states) == 0:
        # The signature changes between the rows, or the section is not met: the turn decides.
        return True
    n = len(a.states)
    aligned = min((np.roll(b.states, k, axis=0) for k in range(n)), key=lambda s: float(np.abs(s - a.states).max()))
    spare = BETWEEN * np.abs(aligned - a.states) + 3 * SPARE * a.sizes
    for z in returns[:1]:
        inside = np.all(
            (z >= np.minimum(a.states, aligned) - spare) & (z <= np.maximum(a.states, aligned) + spare), axis=1
        )
        if not inside.any():
            return False
    return True

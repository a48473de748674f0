"""One random model through the program, through its model by hand, and through the reference."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import sympy

from pddecont.delay import Direct
from pddecont.errors import PddecontError
from pddecont.model import expand_model
from pddecont.simulate import Method, simulate
from tests.conftest import numeric_from
from tests.random_equations.sides import UnsureError

METHOD = Method(1e-11, 1e-12)
T_END, N_TIMES = 15.0, 301
# How far the start is moved to ask how sensitive the motion is, and how sensitive one may be that is compared.
MOVED, TOO_SENSITIVE = 1e-7, 1e4
# The error allowed: this much, times what the motion makes of a change of its start.
ALLOWED = 1e-8
# Models with more guards than this are left out: their machine code takes half a minute and more.
MOST_GUARDS = 80
# States are compared this far from events, where they may jump.
APART = 1e-5


@dataclass
class Trial:
    """What was compared for one model.

    ``outcome`` is "compared", "unsure", "large", "refused" (nothing decides how to slide) or "wrong".
    """

    seed: int
    kinds: list[str]
    outcome: str = "compared"
    why: str = ""
    deviation: float = np.nan
    allowed: float = np.nan
    n_events: int = 0
    slid: float = 0.0
    jumped: bool = False
    expansion: float = 0.0


def try_equations(model):
    """Return the trial of a model."""
    trial = Trial(model.seed, model.kinds)
    try:
        numeric = numeric_from(model.mapping)
    except PddecontError as error:
        return _end(trial, "refused" if "decides how a motion slides" in str(error) else "wrong", str(error))
    if sum(segment.guard != sympy.true for segment in numeric.model.segments.values()) > MOST_GUARDS:
        return _end(trial, "large", f"{len(numeric.model.modes)} modes, {len(numeric.model.segments)} segments")
    try:
        motion = _simulate(numeric)
    except PddecontError as error:
        motion, said = None, str(error)
    except Exception as error:  # whatever comes of code that is made for a model is a fault, and named
        return _end(trial, "wrong", f"{type(error).__name__}: {error}")
    try:
        reference, moved, loose = (model.make_reference(*how).run(T_END) for how in ((1.0,), (1.0, MOVED), (100.0,)))
    except UnsureError as error:
        return _end(trial, "unsure", f"{error}" if motion is not None else f"{error}; the program: {said}")
    if motion is None:
        return _end(trial, "wrong", f"refused in the middle: {said}")
    trial = _compare(trial, motion, reference, moved, loose)
    return _compare_by_hand(trial, numeric.model, motion) if trial.outcome == "compared" else trial


def _compare_by_hand(trial, model, motion):
    """Compare with the motion of the model by hand.

    Its formulas hold the same numbers, but numbers decide in which order sympy adds terms: what differs is rounding,
    and what the choice of steps makes of it.
    """
    try:
        by_hand = _simulate(numeric_from(expand_model(model)))
    except PddecontError as error:
        return _end(trial, "wrong", f"the model by hand is refused: {error}")
    if motion.events.segment != by_hand.events.segment:
        return _end(trial, "wrong", "the model by hand has other events")
    times = _clear_times(motion.events.t)
    trial.expansion = float(np.max(np.abs(motion(times) - by_hand(times))))
    if trial.expansion > trial.allowed:
        return _end(trial, "wrong", f"the model by hand moves otherwise, by {trial.expansion:.1e}")
    return trial


def _simulate(numeric):
    return simulate(numeric, numeric.parameter_values, Direct(), T_END, METHOD)


def _end(trial, outcome, why):
    trial.outcome, trial.why = outcome, " ".join(why.split())
    return trial


def _compare(trial, motion, reference, moved, loose):
    trial.n_events, trial.slid = len(reference.events), reference.slid
    trial.jumped = any("jump" in str(what) for _, what in reference.events)
    names = [[what for _, what in m.events] for m in (reference, moved, loose)]
    if names[0] != names[1] or names[0] != names[2]:
        return _end(trial, "unsure", "another order of events from a start nearby")
    events = np.array([t for m in (reference, moved, loose) for t, _ in m.events])
    times = _clear_times(events)
    states = [np.array([m.read(t) for t in times]) for m in (reference, moved, loose)]
    growth = max(1.0, float(np.max(np.abs(states[1] - states[0]))) / MOVED)
    if growth > TOO_SENSITIVE:
        return _end(trial, "unsure", f"a change of its start grows {growth:.0f} times")
    trial.allowed = ALLOWED * growth
    own = float(np.max(np.abs(states[2] - states[0])))
    if own > 100 * trial.allowed:
        return _end(trial, "unsure", f"the reference is off by {own:.1e} itself at another tolerance")
    # Clocks of sawtooth functions are states of the program alone.
    own_states = motion(times)[:, : states[0].shape[1]]
    deviation = np.max(np.abs(own_states - states[0]), axis=1)
    trial.deviation = float(np.max(deviation))
    if trial.deviation > trial.allowed:
        first = times[np.flatnonzero(deviation > trial.allowed)[0]]
        return _end(
            trial, "wrong", f"apart from t = {first:.4g} on, by {trial.deviation:.1e}; {trial.allowed:.1e} allowed"
        )
    return _compare_times(trial, motion, reference, names[0])


def _clear_times(events):
    """Return times that are apart from all events."""
    times = np.linspace(0.0, T_END, N_TIMES)
    return np.array([t for t in times if not len(events) or np.min(np.abs(events - t)) > APART])


def _compare_times(trial, motion, reference, names):
    """Compare the times of events, those that are one moment taken once."""
    mine, theirs = (_merge(t) for t in (motion.events.t, [t for t, _ in reference.events]))
    # The reference stops in the middle of a sawtooth too, where nothing happens.
    needed = _merge([t for t, what in reference.events if not str(what).startswith("angle")])
    for some, others, who in ((mine, theirs, "the reference"), (needed, mine, "the program")):
        far = [t for t in some if not len(others) or np.min(np.abs(others - t)) > 100 * trial.allowed]
        if far:
            return _end(trial, "wrong", f"at t = {far[0]:.6g} {who} has no event")
    return trial


def _merge(times):
    kept = []
    for t in sorted(times):
        if (not kept or t - kept[-1] > 1e-7) and 1e-7 < t < T_END - 1e-7:
            kept.append(t)
    return np.array(kept)

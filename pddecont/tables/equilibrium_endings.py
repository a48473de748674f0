"""How equilibrium steps ended, in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pddecont.reasons import Reason
from pddecont.results import Step
from pddecont.tables.equilibria import list_doubts, read_mode, read_roots

# States that are named one by one.
MANY = 6
# Places that are named one by one.
NAMED = 3
# A place narrower than this part of the box is a point to who reads of it.
NARROW = 1e-4
UNCOUNTED = (
    "the count of characteristic roots does not confirm those that were found: whether it is stable is not known"
)

# By whether it is recorded as stable.
WITHOUT_UNSTABLE = {
    1: "stable",
    0: "no root to the right of the imaginary axis",
    -1: "no root to the right of the imaginary axis but at least one on it: the roots do not tell whether it is stable",
}


def describe_equilibrium_step(step: Step, ending: Reason) -> str:
    """Return what a step found: one equilibrium near a guess, or those in a box and whether these are all."""
    switchings = describe_switchings(step.meta["states"], step.meta.get("switchings", []))
    doubts = "".join(f"; WARNING: {doubt}" for doubt in list_doubts(step))
    if ending.code == "equilibrium":
        return f"{_describe_one(step)}{doubts}{switchings}"
    places = [place for place in step.meta["undecided"] if not place["virtual"]]
    hidden = len(step.meta["undecided"]) > len(places)
    number = int(np.sum(step.points["admissible"] != 0))
    text = "1 equilibrium" if number == 1 else f"{number or 'no'} equilibria"
    if not places:
        text = f"{('no', 'the only')[number]} equilibrium" if number < 2 else f"all {number} equilibria"
    text += f" in the box{_describe_virtual(len(step) - number, hidden)}"
    unknown = int(np.sum(step.points["n_unstable"] < 0))
    text += f"; WARNING: at {unknown} of them {UNCOUNTED}" if unknown else ""
    text += f"; WARNING: {_describe_places(step, places)}" if places else ""
    return f"{text}{doubts}{switchings}"


def describe_switchings(states: Sequence[str], switchings: Sequence[Mapping[str, Any]]) -> str:
    """Return where a law that switches on past values cannot rest; nothing where there is no such place."""
    words = [
        f"; at {_name_states(states, one['states'])} modes {' and '.join(repr(mode) for mode in one['modes'])} push to "
        f"the surface of event '{one['event']}' from both sides, but it is crossed by past values: no rest there, but "
        "orbits, the smaller the shorter the delay"
        for one in switchings[:NAMED]
    ]
    more = len(switchings) - NAMED
    return "".join(words) + (f", and {more} more such place{'s'[: more - 1]}" if more > 0 else "")


def _name_states(states: Sequence[str], values: Sequence[float]) -> str:
    named = [f"{name} = {value:.10g}" for name, value in zip(states, values, strict=True)]
    more = f" and {len(named) - MANY} more states" if len(named) > MANY else ""
    return f"{', '.join(named[:MANY])}{more}"


def _describe_virtual(number: int, hidden: bool) -> str:
    """Return how many equilibria lie where their modes do not hold; there may be more, ``hidden``."""
    if number == 0:
        return "; there may be virtual ones, where their modes do not hold" if hidden else ""
    if number == 1 and not hidden:
        return "; also 1 virtual one, where its mode does not hold"
    return f"; also {number}{' or more' if hidden else ''} virtual ones, where their modes do not hold"


def _describe_one(step: Step) -> str:
    p, roots = step.points, read_roots(step, 0)
    states = _name_states(step.meta["states"], p["states"][0].tolist())
    mode = f" in mode '{read_mode(step, 0)}'" if len(step.meta["modes"]) > 1 else ""
    leading = f", leading root {_format_root(complex(roots[0]))}" if len(roots) else ""
    n, text = int(p["n_unstable"][0]), f"{states}{mode}"
    if n < 0:
        text += f"{leading}; WARNING: {UNCOUNTED}"
    elif n:
        text += f"; unstable ({n} root{'s'[: n - 1]} to the right of the imaginary axis){leading}"
    else:
        text += f"; {WITHOUT_UNSTABLE[int(p['stable'][0])]}{leading}"
    return text if p["admissible"][0] else f"{text}; WARNING: virtual, its mode does not hold there"


def _format_root(root: complex) -> str:
    return f"{root.real:.6g}" if root.imag == 0.0 else f"{root.real:.6g} {root.imag:+.6g}i"


def _describe_places(step: Step, places: Sequence[Mapping[str, Any]]) -> str:
    """Return where equilibria may have been missed."""
    box, modes, number = step.meta["search"], len(step.meta["modes"]) > 1, len(places)
    named = " and ".join(_name_place(step.meta["states"], box, place, modes) for place in places[:NAMED])
    more = f" and {number - NAMED} more" if number > NAMED else ""
    return (
        f"{number} place{'s'[: number - 1]} undecided, {named}{more}; there may be more there: a smaller box may "
        "decide, but not where equilibria meet or lie along a curve"
    )


def _name_place(states: Sequence[str], box: Mapping[str, Any], place: Mapping[str, Any], modes: bool) -> str:
    points, ranges = [], []
    for name, low, high in zip(states, place["low"], place["high"], strict=True):
        below, above = box[name]
        if high - low < NARROW * (above - below):
            points.append(f"{name} = {0.5 * (low + high):.6g}")
        else:
            ranges.append(f"{name} from {low:.6g} to {high:.6g}")
    where = "".join(
        [f"near {', '.join(points)}" if points else "", " with " if points and ranges else "", ", ".join(ranges)]
    )
    return f"{where} (mode '{place['mode']}')" if modes else where

"""What an orbit of a model given by its equations does at surfaces along which motions can slide.

Names are those of di Bernardo, Budd, Champneys, Kowalczyk, Piecewise-smooth Dynamical Systems (2008), chapter 8.
"""

from __future__ import annotations

import numpy as np

from pddecont.model import ABOVE, BELOW, ON, Crossing, DerivedModes, find_surface, list_exits
from pddecont.orbit.event_profiles import find_event_profile
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.signature import Signature

CROSSING, GRAZING, SWITCHING, ADDING = "CS", "GS", "SS", "AS"


def name_guard(orbit: Orbit, s: int) -> str:
    """Return what happens where the condition of segment ``s`` changes; empty if it decides on no sliding.

    Where a crossing begins to stick, or what sticks leaves at once, it is crossing-sliding. Where the motion enters at
    the boundary of the sliding region and is drawn into it, it is switching-sliding.
    """
    found = _find_crossing(orbit.signature, s)
    if found is None:
        return ""
    derived, crossing = found
    segments = orbit.signature.segments
    here, following = segments[s], segments[(s + 1) % len(segments)]
    if not derived.surfaces.slides[crossing.switch]:
        return ""
    if derived.find_digits(here.to)[crossing.switch] != ON:
        return CROSSING
    exits = (e for e in list_exits(derived, here.to) if (e[1].switch, e[1].up) == (crossing.switch, crossing.up))
    event = next((name for name, _ in exits), None)
    if event is None or following.mode != here.to:
        return CROSSING
    slope = find_event_profile(orbit, event).start_slope((s + 1) % len(segments))
    return CROSSING if slope * (1.0 if crossing.up else -1.0) > 0.0 else SWITCHING


def name_grazing(orbit: Orbit, s: int, event: str) -> str:
    """Return what happens where segment ``s`` grazes an event; empty where nothing begins to slide or ceases to."""
    derived = orbit.numeric.model.derived
    if derived is None:
        return ""
    mode = orbit.signature.segments[s].mode
    if any(name == event for name, _ in list_exits(derived, mode)):
        return ADDING
    switch = find_surface(derived, mode, event)
    if switch is None or not derived.surfaces.slides[switch]:
        return ""
    times = [e.time for e in find_event_profile(orbit, event).extrema if e.segment == s]
    return GRAZING if times and _is_attracting(orbit, derived, switch, s, times) else ""


def name_vanishing(signature: Signature, s: int) -> str:
    """Return what happens where segment ``s`` vanishes; empty if it does not slide."""
    model = signature.numeric.model
    segments = signature.segments
    here, before, after = segments[s], segments[s - 1], segments[(s + 1) % len(segments)]
    if model.derived is None or not here.event:
        return ""
    crossing = model.derived.find_crossing(here)
    if crossing is None or not crossing.leaves or before.to != here.mode:
        return ""
    came, went = (model.derived.find_digits(mode)[crossing.switch] for mode in (before.mode, after.mode))
    if {came, went} == {ABOVE, BELOW}:
        return CROSSING
    return GRAZING if came == went != ON else ""


def _is_attracting(orbit: Orbit, derived: DerivedModes, switch: int, s: int, times: list[float]) -> bool:
    """Return whether motions slide along the surface of a switch where segment ``s`` is at some times."""
    low, high = derived.surfaces.find_bounds(switch, derived.find_digits(orbit.signature.segments[s].mode))
    place = orbit.mesh.locate(orbit.theta, np.array(times), segment=s)[0]
    reads = orbit.read(place)
    values = orbit.numeric.function([high - low]).value(reads.t, reads.x, reads.xd, orbit.parameters)
    return bool(np.all(values < 0.0))


def _find_crossing(signature: Signature, s: int) -> tuple[DerivedModes, Crossing] | None:
    derived = signature.numeric.model.derived
    crossing = None if derived is None else derived.find_crossing(signature.segments[s])
    return None if derived is None or crossing is None or crossing.leaves else (derived, crossing)

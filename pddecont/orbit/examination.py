"""What the motion does that has an orbit as its past: simulations across the end of each of its segments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pddecont.memo import cached_property
from pddecont.orbit.clocks import list_started_events
from pddecont.orbit.error import estimate_interval_errors, measure_states
from pddecont.orbit.orbit import Orbit
from pddecont.orbit.past import make_past
from pddecont.orbit.reach import find_reach
from pddecont.simulate import MotionRecord, ParameterValues, Past, Simulator, follow_motion, restart_motion

Array = NDArray[np.float64]
# The error allowed in a step of the simulation, relative to the size of the states.
RTOL, ATOL = 1e-9, 1e-11
# Where models read more than states a constant time ago, steps pass over the edges of the orbit's polynomials, and
# their errors are some thirty times as large at the same tolerance.
FINE_RTOL = 1e-11
# Steps after which a simulation is given up, and done with the next simulator instead.
MAX_STEPS = 4000
# How much more of the past is kept than delays reach back, relative to them.
REACH = 1e-9


@dataclass(frozen=True, eq=False)
class Window:
    """A simulation from a place in segment ``s`` to the same place in the next one: what it starts from and expects.

    Times count from the orbit's start; ``states`` and ``target`` are the orbit's at the two ends (n_states,).
    """

    s: int
    begin: float
    event: float
    end: float
    states: Array
    target: Array


@dataclass(frozen=True, eq=False)
class Examination:
    """One orbit and what simulates it: ``simulators`` are tried in turn; ``driven`` ones are given delayed values."""

    orbit: Orbit
    simulators: Sequence[Simulator]
    driven: bool
    _values: dict[Simulator, ParameterValues] = field(default_factory=dict)

    @cached_property
    def sizes(self) -> Array:
        """The size of each state (n_states,)."""
        return measure_states(self.orbit.values)

    @cached_property
    def remoteness(self) -> float:
        """How many times larger a state is than what it moves by, at most; one or more."""
        return float(max(1.0, np.max(np.max(np.abs(self.orbit.values), axis=0) / self.sizes)))

    @cached_property
    def error(self) -> float:
        """The orbit's estimated error, relative to its size."""
        return float(np.max(estimate_interval_errors(self.orbit)))

    def find_values(self, simulator: Simulator) -> ParameterValues:
        """Return the model's numbers at the orbit's parameters, for one of the simulators."""
        if simulator not in self._values:
            atol = ATOL * float(np.min(self.sizes))
            self._values[simulator] = simulator.values(self.orbit.parameters)._replace(atol=atol)
        return self._values[simulator]

    @cached_property
    def past(self) -> Past:
        """The orbit as far back as a delay reaches from any segment."""
        orbit = self.orbit
        if self.driven:
            return make_past(orbit, 0.0, 2.0 * orbit.period, delayed=True)
        longest = find_reach(orbit)
        # Windows begin within the first period.
        return make_past(orbit, -longest * (1.0 + REACH), orbit.period)

    @cached_property
    def started(self) -> list[tuple[float, float, str]]:
        """The delayed events that the orbit's events start."""
        return list_started_events(self.orbit)

    def list_windows(self, place: float) -> list[Window]:
        """Return what is simulated across the end of each segment, from ``place`` in it to that in the next one."""
        orbit, n = self.orbit, len(self.orbit.signature)
        ends = orbit.event_times[1:]
        begins = orbit.event_times[:-1] + place * orbit.durations
        following = np.arange(1, n + 1) % n
        states = orbit.mesh.interpolate(orbit.values, orbit.mesh.locate(orbit.theta, begins)[0])
        beyond = ends + place * orbit.durations[following]
        return [
            Window(s, float(begins[s]), float(ends[s]), float(beyond[s]), states[s], states[(s + 1) % n])
            for s in range(n)
        ]

    def simulate(self, window: Window, moved: float = 0.0) -> MotionRecord | None:
        """Return what the motion does in a window; None if it takes too many steps.

        It begins at the orbit, ``moved`` from there relative to the size of the states.
        """
        orbit = self.orbit
        begin = orbit.start + window.begin
        pending = [(orbit.start + t, name) for t, since, name in self.started if since < window.begin < t <= window.end]
        mode = orbit.signature.segments[window.s].mode
        states = window.states + moved * self.sizes
        for simulator in self.simulators:
            values = self.find_values(simulator)
            if self.driven:
                ago = (window.end - window.begin) * (1.0 + REACH)
                values = values._replace(tau=np.array([ago]), longest=ago, max_step=min(ago, values.max_step))
                past = self.past.between(begin, orbit.start + window.end).shift(-ago)
            else:
                past = self.past.until(begin)
                past = replace(past, value=past.value + moved * self.sizes) if moved else past
            state = restart_motion(simulator, values, past, begin, states, mode, pending)
            record = follow_motion(simulator, values, state, orbit.start + window.end, MAX_STEPS)
            if record is not None:
                return record
        return None

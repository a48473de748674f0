"""How far and how fast motions of a model go, seen from a few: a box for others to start in, a time to settle."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.delay import DelayMethod
from pddecont.errors import ConvergenceError
from pddecont.simulate import Method, Trajectory, simulate

Array = NDArray[np.float64]
# Times at which a first motion is looked at: the first, and by how much each is longer than the one before.
FIRST_TIME, LONGER, LONGEST_TIME = 1e-6, 4.0, 1e8
# Turns of some state after which it is known how fast motions go, and steps after which it is enough.
N_TURNS, MAX_STEPS = 40, 20_000
# How far from the model's own start the second motion begins, beside the size of each state.
ASIDE = 0.1
# A motion whose last half covers less than this part of the whole has come to rest.
STILL = 1e-5
# Times that long for motions to settle: of those with turns, and of those that come to rest.
TURNING, RESTING = 10.0, 4.0
# The longest time for those that rest, by that of those with turns.
LATER = 4.0
# By how much the box is wider than what motions were seen to cover, on either side.
MARGIN = 0.1
# A state that is as little beyond zero as this part of what it covers is not beyond it.
ROUNDING = 1e-9
# The box of a model whose motions were all seen to stay where they begin, on either side.
BESIDE = 1.0


@dataclass(frozen=True, eq=False)
class Pilot:
    """One motion: its parameters, whether it still moves at its end, and whether its length tells how fast it goes."""

    parameters: Array
    trajectory: Trajectory
    moves: bool
    has_time: bool = True

    @property
    def time(self) -> float:
        """How long it takes to know how fast it goes."""
        return self.trajectory.t_end

    def sample(self, part: float = 1.0) -> Array:
        """Return the states along the last ``part`` of the motion, shape (n, n_states)."""
        times, states, _ = self.trajectory.sample()
        return states[times >= (1.0 - part) * self.trajectory.t_end]


@dataclass(frozen=True, eq=False)
class Survey:
    """What a few motions tell: where others are to start (n_states,) twice, how long they settle, where returns are.

    ``event`` is an event of the model that they keep meeting ("": none), ``state`` one that goes through a level again
    and again, ``level`` the numbers c of that, ``c[0] + c[1:] . parameters``. ``phase`` is the part of a forcing period
    after which no event comes.
    """

    low: Array
    high: Array
    transient: float
    event: str
    state: int
    level: Array
    phase: float


def fly_pilots(
    numeric: NumericModel, delay: DelayMethod, method: Method, points: Iterable[Array], own: Sequence[int]
) -> list[Pilot]:
    """Return motions at each parameter point, as long as it takes; none where it cannot be followed.

    One begins where the model says, one beside it: the model's own start may be an equilibrium. ``own`` are the numbers
    of the states that may begin anywhere, which clocks and the like may not.
    """
    model, found = numeric.model, []
    for p in points:
        values = dict(zip(model.parameters, p.tolist(), strict=True))
        start = np.array([model.evaluate(e, values, 0.0) for e in model.history])
        beside = start.copy()
        beside[list(own)] += ASIDE * (1.0 + np.abs(start[list(own)]))
        for initial in (start, beside):
            try:
                found.append(_fly(numeric, p, delay, method, initial))
            except ConvergenceError:
                continue
    return found


def _fly(numeric: NumericModel, p: Array, delay: DelayMethod, method: Method, initial: Array) -> Pilot:
    model = numeric.model
    mode = model.initial_mode if model.derived is None else None
    time = N_TURNS * float(numeric.period.value(p)[0]) if model.forced else FIRST_TIME
    while True:
        trajectory = simulate(numeric, p, delay, time, method, initial=initial.tolist(), mode=mode, constant=True)
        _, states, _ = trajectory.sample()
        whole = np.ptp(states, axis=0)
        # In a short time nothing rests: it moves as much in the later half as in the earlier one.
        rests = bool(np.all(np.ptp(states[len(states) // 2 :], axis=0) <= STILL * whole))
        n_turns = max(np.count_nonzero(np.diff(np.sign(np.diff(column)))) for column in states.T)
        stays = not np.any(whole > 0.0) and not model.forced
        if model.forced or n_turns >= N_TURNS or trajectory.n_steps > MAX_STEPS or (rests and not stays):
            return Pilot(p, trajectory, not rests)
        if time > LONGEST_TIME:
            return Pilot(p, trajectory, moves=False, has_time=False)
        time *= LONGER


def make_survey(numeric: NumericModel, pilots: Sequence[Pilot], free: Sequence[int], own: Sequence[int]) -> Survey:
    """Return what pilots tell; ``free`` are the numbers of the parameters that vary, ``own`` those of the states."""
    n = numeric.n_states
    covered = [pilot.sample() for pilot in pilots] or [np.zeros((1, n))]
    low, high = (np.array(find([find(states, axis=0) for states in covered], axis=0)) for find in (np.min, np.max))
    width = high - low
    width = np.where(width > 0.0, width, BESIDE / MARGIN * (1.0 + np.abs(high)))
    moving = [pilot for pilot in pilots if pilot.moves]
    events = Counter(event for pilot in moving for event in _list_late_events(numeric, pilot))
    state, level = _find_level(moving or pilots, free, own)
    # What was never negative (a population, a height above the ground), or never positive, does not become so.
    least, most = low - MARGIN * width, high + MARGIN * width
    moves = high > low
    lowest = np.where(moves & (low >= -ROUNDING * width), np.maximum(least, 0.0), least)
    highest = np.where(moves & (high <= ROUNDING * width), np.minimum(most, 0.0), most)
    return Survey(
        lowest,
        highest,
        _choose_transient(pilots),
        max(events, key=lambda name: events[name], default=""),
        state,
        level,
        _find_phase(numeric, pilots) if numeric.model.forced else 0.0,
    )


def _choose_transient(pilots: Sequence[Pilot]) -> float:
    """Return how long motions settle; where some go on turning, one that rests late is not waited for too long."""
    turning = [TURNING * pilot.time for pilot in pilots if pilot.has_time and pilot.moves]
    resting = [RESTING * pilot.time for pilot in pilots if pilot.has_time and not pilot.moves]
    if not turning:
        return max(resting, default=1.0)
    return max(turning) if not resting else max(max(turning), min(max(resting), LATER * max(turning)))


def _find_phase(numeric: NumericModel, pilots: Sequence[Pilot]) -> float:
    """Return the part of a forcing period amid the longest time in which no motion has an event; 0 without events."""
    found = [
        pilot.trajectory.events.t[pilot.trajectory.events.t > 0.5 * pilot.time]
        / float(numeric.period.value(pilot.parameters)[0])
        for pilot in pilots
    ]
    phases = np.sort(np.concatenate([np.zeros(0), *found]) % 1.0)
    if not len(phases):
        return 0.0
    gaps = np.diff(phases, append=phases[0] + 1.0)
    widest = int(np.argmax(gaps))
    return float((phases[widest] + 0.5 * gaps[widest]) % 1.0)


def _list_late_events(numeric: NumericModel, pilot: Pilot) -> set[str]:
    """Return the events that a motion meets in its last half."""
    events = pilot.trajectory.events
    late = [name for t, name in zip(events.t, events.segment, strict=True) if t > 0.5 * pilot.trajectory.t_end]
    return {numeric.model.segments[name].event for name in late}


def _find_level(pilots: Sequence[Pilot], free: Sequence[int], own: Sequence[int]) -> tuple[int, Array]:
    """Return the state that moves most, and the level that is amid its motions, linear in the free parameters."""
    if not pilots:
        return 0, np.zeros(1 + len(free))
    late = [pilot.sample(0.5) for pilot in pilots]
    extents = np.max([np.ptp(states, axis=0) / (1e-300 + np.max(np.abs(states), axis=0)) for states in late], axis=0)
    state = max(own, key=lambda k: float(extents[k]))
    middles = np.array([0.5 * (states[:, state].min() + states[:, state].max()) for states in late])
    places = np.array([pilot.parameters[list(free)] for pilot in pilots])
    level = np.zeros(1 + len(free))
    if len(pilots) > len(free):
        level, *_ = np.linalg.lstsq(np.column_stack([np.ones(len(pilots)), places]), middles)
    else:
        level[0] = float(np.mean(middles))
    return state, level

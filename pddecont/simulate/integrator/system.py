"""A model in numbers: what depends on the model alone, and what depends on its parameters."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


class System(NamedTuple):
    """A model in numbers; nothing here depends on parameter values.

    Attributes
    ----------
    field, event, reset, guard, repulsion, history, field_jacobian, event_jacobian, reset_jacobian
        Addresses of the model's compiled functions; 0 for one that is not needed.
    field_case
        What the vector field and its Jacobian know each mode by (n_modes,).
    n, n_full
        States, and states with the variables of a chain.
    tangent
        1 if a tangent is integrated along with the states.
    pair_state, pair_delay
        State and delay of each delayed value (n_pairs,).
    kept, place
        States whose past is kept (n_kept,), and where each state is among them (n,): -1 for one that is not kept.
    segment_mode, segment_event, segment_direction, segment_reset, segment_to
        The segments in declared order (n_segments,); a direction is 1 rising, -1 falling, 0 any.
    alternatives
        How many segments, from this one on, it may turn out to be when it ends: the first whose guard holds
        (n_segments,).
    segment_repulsion
        The condition under which both fields point away from a surface after each segment (n_segments,); -1: none.
    segment_opposite
        Of a segment that leaves a surface the first one that leaves it to the other side (n_segments,); -1: others.
    resting
        What each segment is where its event accumulates and the motion rests (n_segments,); -1: nothing is said of it.
    crossing_first, crossing_segment
        The segments of mode m that end at event functions: crossing_segment[crossing_first[m]:crossing_first[m + 1]].
        Of alternatives the first stands for all.
    ending_first, ending_segment
        All segments of a mode, likewise.
    held_first, held_event
        The events on whose surfaces a motion slides in each mode, likewise.
    clock_first, clock_event
        The delayed events that an event starts, likewise.
    after
        The event that a delayed event follows (n_events,); -1 for one with an event function.
    reads
        1 for an event function that reads delayed values (n_events,).
    chain_order, chain_n
        Order and length of the explicit chain; 0 where delayed values come from the past.
    section, section_direction
        The event function that only marks returns (-1: none) and the direction in which it does.
    stop_event
        The event at which to come back (-1: none).
    stiff
        1 for Radau IIA, 0 for DOP853.
    n_modes
        Modes of the model.
    """

    field: int
    field_case: Integers
    event: int
    reset: int
    guard: int
    repulsion: int
    history: int
    field_jacobian: int
    event_jacobian: int
    reset_jacobian: int
    n: int
    n_full: int
    tangent: int
    pair_state: Integers
    pair_delay: Integers
    kept: Integers
    place: Integers
    segment_mode: Integers
    segment_event: Integers
    segment_direction: Integers
    segment_reset: Integers
    segment_to: Integers
    alternatives: Integers
    resting: Integers
    segment_guard: Integers
    segment_repulsion: Integers
    segment_opposite: Integers
    crossing_first: Integers
    crossing_segment: Integers
    ending_first: Integers
    ending_segment: Integers
    held_first: Integers
    held_event: Integers
    clock_first: Integers
    clock_event: Integers
    after: Integers
    reads: Integers
    chain_order: int
    chain_n: int
    section: int
    section_direction: int
    stop_event: int
    stiff: int
    n_modes: int


class ParameterValues(NamedTuple):
    """A model's numbers at given parameters, and what limits steps.

    Attributes
    ----------
    p, tau, event_delay
        Parameters (n_parameters,), delays (n_delays,), and the delay of each event that is a delayed one (n_events,).
    max_step
        The longest step.
    rtol, atol
        The error allowed in a step, relative and absolute.
    longest
        How much of the past is kept.
    """

    p: Array
    tau: Array
    event_delay: Array
    max_step: float
    rtol: float
    atol: float
    longest: float

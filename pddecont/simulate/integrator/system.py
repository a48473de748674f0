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
    field, field_jacobian, field_case
        The addresses of each mode's vector field and of its Jacobian, 0 for one that is not needed, and what these
        functions know the mode by (n_modes,).
    event, event_jacobian, event_case
        The same of event functions (n_events,).
    reset, reset_jacobian, reset_case
        The same of resets (n_resets,).
    history
        The address of the history.
    n, n_full
        States, and states with the variables of a chain.
    tangent
        1 if a tangent is integrated along with the states.
    pair_state, pair_delay
        State and delay of each delayed value (n_pairs,).
    kept, place
        States whose past is kept (n_kept,), and where each state is among them (n,): -1 for one that is not kept.
    segment_mode, segment_event, segment_direction, segment_reset, segment_to
        The segments (n_segments,); a direction is 1 rising, -1 falling, 0 any. Of one whose mode is not in the tables
        yet ``segment_to`` is -1.
    segment_next_way
        The next segment that it may turn out to be when it ends (n_segments,); -1: no other is in the tables.
    segment_repulsion, segment_repulsion_case
        The address of the condition under which both fields point away from a surface after each segment, 0 for none,
        and what it is known by there (n_segments,).
    segment_opposite
        Of a segment that leaves a surface the first one that leaves it to the other side (n_segments,); -1: others.
    resting
        What each segment is where its event accumulates and the motion rests (n_segments,); -1: nothing is said of it.
    segment_decision_first, segment_decision_end
        Of the first of them: the decisions that say which it is, in order.
    n_digits, n_keys
        Switches whose digits conditions read, and numbers that tell the ways of one segment apart: the digits, or of a
        model by hand one number.
    leader_digits, way_digits
        These numbers where nothing has been decided, and after each segment (n_segments, n_keys).
    option_first, option_end, is_open
        The options of each decision, and 1 where it may be that none of them holds (n_decisions,).
    number_first, decision_size, decided
        Decision d chooses the numbers decided[number_first[d]:number_first[d] + decision_size[d]].
    rule, rule_case
        The address of each option's condition, and what it is known by there (n_options,).
    digit_first, decided_digit
        What each option gives these numbers, likewise.
    crossing_first, crossing_segment
        The segments of mode m that end at event functions: crossing_segment[crossing_first[m]:crossing_first[m + 1]].
        Of those that one may turn out to be the first stands for all.
    ending_first, ending_segment
        All segments of a mode, likewise.
    held_first, held_event
        The events on whose surfaces a motion slides in each mode, likewise.
    clock_first, clock_event
        The delayed events that an event starts, likewise.
    after
        0 for a delayed event, -1 for one with an event function (n_events,).
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
    is_general
        1 where values are read by lags that vary, as rates, or as integrals; 0 where all of them are states constant
        delays ago. What follows is read only where it is 1.
    n_values
        Delayed values; integrals come after them. The state and delay of an integral are -1.
    n_varying, n_integrals, n_turns, n_first_turns
        Lags that vary (their slots come after those of the constant ones), integrals, turns, and those of them that
        come first: only derivatives need the others.
    pair_derivative, is_rate
        How often each value that is read is differentiated, and 1 for a rate that fields depend on (n_pairs,).
    turn_kind, turn_number
        What to evaluate in order: 0 a lag that varies, 1 a delayed value, 2 an integral, and its number (n_turns,).
    low, high
        The slots of each integral's limits (n_integrals,); -1 for zero.
    gain
        By how many orders a jump is smoother where a slot brings it back (n_slots,).
    lags, integrands
        The addresses of the lags that vary, and of the integrands g: case 2 q is g, case 2 q + 1 dg/ds and dg/dx.
    """

    field: Integers
    field_jacobian: Integers
    field_case: Integers
    event: Integers
    event_jacobian: Integers
    event_case: Integers
    reset: Integers
    reset_jacobian: Integers
    reset_case: Integers
    history: int
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
    segment_next_way: Integers
    resting: Integers
    segment_repulsion: Integers
    segment_repulsion_case: Integers
    segment_opposite: Integers
    segment_decision_first: Integers
    segment_decision_end: Integers
    n_digits: int
    n_keys: int
    leader_digits: Integers
    way_digits: Integers
    option_first: Integers
    option_end: Integers
    is_open: Integers
    number_first: Integers
    decision_size: Integers
    decided: Integers
    rule: Integers
    rule_case: Integers
    digit_first: Integers
    decided_digit: Integers
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
    is_general: int
    n_values: int
    n_varying: int
    n_integrals: int
    n_turns: int
    n_first_turns: int
    pair_derivative: Integers
    is_rate: Integers
    turn_kind: Integers
    turn_number: Integers
    low: Integers
    high: Integers
    gain: Integers
    lags: int
    integrands: int


class ParameterValues(NamedTuple):
    """A model's numbers at given parameters, and what limits steps.

    Attributes
    ----------
    p, tau, event_delay
        Parameters (n_parameters,), constant delays and limits of integrals (n_delays,), and the delay of each event
        that is a delayed one (n_events,).
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

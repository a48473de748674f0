"""All of an integration by name: what its functions read and write.

Python's records System, ParameterValues, IntegratorState, Log and Workspace say what each field is, by the same name; a
number of things is n_..., the log's are log_..., its events' event_....
"""

from __future__ import annotations

from typing import NamedTuple

from pddecont.native.arrays import Floats, Integers


class Core(NamedTuple):
    """An integration; the arrays have to outlive it."""

    # The model's functions: their addresses and what these know each mode, event or reset by.
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
    lags: int
    integrands: int
    # Numbers of things; ``dimension`` counts all that is integrated, ``mask`` is the length of the ring less one.
    n: int
    n_full: int
    dimension: int
    tangent: int
    n_pairs: int
    n_delays: int
    n_kept: int
    n_segments: int
    n_events: int
    n_digits: int
    n_keys: int
    n_values: int
    n_varying: int
    n_integrals: int
    n_turns: int
    n_first_turns: int
    mask: int
    log_steps: int
    log_events: int
    # What is read of the past.
    pair_state: Integers
    pair_delay: Integers
    pair_derivative: Integers
    is_rate: Integers
    kept: Integers
    place: Integers
    reads: Integers
    is_general: int
    turn_kind: Integers
    turn_number: Integers
    low: Integers
    high: Integers
    gain: Integers
    chain_order: int
    chain_n: int
    # Segments, and what decides which of several one is.
    segment_mode: Integers
    segment_event: Integers
    segment_direction: Integers
    segment_reset: Integers
    segment_to: Integers
    segment_next_way: Integers
    segment_repulsion: Integers
    segment_repulsion_case: Integers
    segment_opposite: Integers
    segment_decision_first: Integers
    segment_decision_end: Integers
    resting: Integers
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
    # What each mode, or event, has, in lists one after the other.
    crossing_first: Integers
    crossing_segment: Integers
    ending_first: Integers
    ending_segment: Integers
    held_first: Integers
    held_event: Integers
    clock_first: Integers
    clock_event: Integers
    after: Integers
    # Where and how to integrate.
    section: int
    section_direction: int
    stop_event: int
    stiff: int
    max_step: float
    rtol: float
    atol: float
    longest: float
    # Parameters and delays.
    p: Floats
    tau: Floats
    event_delay: Floats
    # The present.
    clock: Floats
    count: Integers  # type: ignore[assignment]
    y: Floats
    constant: Floats
    cursor: Integers
    reading: Integers
    segment_counts: Integers
    side: Integers
    residue: Floats
    next_step: Floats
    resume: Integers
    accumulation: Floats
    # The past, a ring of steps.
    past_time: Floats
    past_length: Floats
    past_end: Floats
    past_arc: Integers
    past_shift: Floats
    past_value: Floats
    past_coefficients: Floats
    past_piece: Integers
    past_level: Integers
    past_size: Floats
    # What is to come.
    pending_time: Floats
    pending_event: Integers
    pending_shift: Floats
    breaking_time: Floats
    breaking_level: Integers
    breaking_size: Floats
    # Lags that vary.
    lag_time: Floats
    lag_count: Integers
    # The log.
    log_n: Integers
    log_time: Floats
    log_length: Floats
    log_end: Floats
    log_mode: Integers
    log_arc: Integers
    log_value: Floats
    log_coefficients: Floats
    event_time: Floats
    event_segment: Integers
    event_arc: Integers
    event_before: Floats
    event_after: Floats
    # Intermediate results.
    stages: Floats
    extension: Floats
    trial: Floats
    slope: Floats
    xd: Floats
    xd_slope: Floats
    jacobian: Floats
    gradient: Floats
    after_reset: Floats
    past_trial: Floats
    crossing: Integers
    passed: Integers
    found_side: Integers
    bernstein: Floats
    stack: Floats
    digits: Integers
    asked: Integers
    landing: Floats
    lag: Floats
    lag_least: Floats
    lag_most: Floats
    held: Floats
    fresh_slope: Floats
    inside: Floats
    integrand: Floats
    panels: Floats
    sums: Floats
    # Of the stiff method: derivatives of all slopes, a matrix with its factors, and the steps of Newton's method.
    full_jacobian: Floats
    matrix: Floats
    pivots: Integers
    increments: Floats
    change: Floats


class Returns(NamedTuple):
    """The last returns of a motion, as Python's ReturnBuffer says, and how large they are: ``size`` and ``noise``.

    ``width`` is the length of a row of ``states``, ``n_compared`` how much of it tells motions apart, ``n_distances``
    the length of a row of ``distances``, ``n_segments`` that of one of ``segment_counts``.
    """

    capacity: int
    width: int
    n_compared: int
    n_distances: int
    n_segments: int
    states: Floats
    times: Floats
    segment_counts: Integers
    distances: Floats
    running: Integers
    number: Integers
    stop: Floats
    size: Floats
    noise: Floats

"""All of an integration in one tuple of plain numbers and pointers, for the functions that run inside a step.

An argument that is a tuple of arrays costs numba a count of references for each array at each call, more than the
arithmetic does; numbers and pointers cost nothing.
"""

from __future__ import annotations

from collections import namedtuple

from pddecont.simulate.integrator.calls import internal, pointer

# What System, ParameterValues and IntegratorState hold under the same names, with lengths as n_..., the length of the
# ring less one as mask, the arrays of the log as log_... and event_..., and the Workspace. Arrays of several dimensions
# lie row by row.
Core = namedtuple(
    "Core",
    """
    field field_jacobian field_case event event_jacobian event_case reset reset_jacobian reset_case
    history n n_full dimension tangent
    n_pairs n_delays n_kept n_segments n_events pair_state pair_delay kept place segment_mode segment_event
    segment_direction segment_reset segment_to segment_next_way resting segment_repulsion
    segment_repulsion_case segment_opposite segment_decision_first segment_decision_end
    n_digits n_keys leader_digits way_digits option_first option_end is_open number_first decision_size decided
    rule rule_case digit_first decided_digit
    crossing_first crossing_segment ending_first ending_segment
    held_first held_event     clock_first clock_event after reads chain_order chain_n section section_direction
    stop_event stiff p tau event_delay max_step rtol atol longest clock count y constant mask past_time
    past_length past_end past_arc past_shift past_value past_coefficients cursor reading pending_time
    pending_event pending_shift breaking_time breaking_level accumulation segment_counts side residue next_step resume
    log_steps log_events log_n log_time log_length log_end log_mode log_arc log_value log_coefficients event_time
    event_segment event_arc event_before event_after stages extension trial slope xd xd_slope jacobian gradient
    after_reset past_trial crossing passed found_side bernstein stack digits asked landing
    is_general n_values n_varying n_integrals n_turns n_first_turns pair_derivative is_rate turn_kind turn_number
    low high gain lags integrands past_piece past_level past_size breaking_size lag_time lag_count lag
    lag_least lag_most held fresh_slope inside integrand panels
""",
)


@internal
def make_core(system, values, state, log, work):
    """Return an integration in plain numbers and pointers; the arrays that it points to have to outlive it."""
    return Core(
        pointer(system.field),
        pointer(system.field_jacobian),
        pointer(system.field_case),
        pointer(system.event),
        pointer(system.event_jacobian),
        pointer(system.event_case),
        pointer(system.reset),
        pointer(system.reset_jacobian),
        pointer(system.reset_case),
        system.history,
        system.n,
        system.n_full,
        len(state.y),
        system.tangent,
        len(system.pair_state),
        len(values.tau),
        len(system.kept),
        len(system.segment_mode),
        len(system.after),
        pointer(system.pair_state),
        pointer(system.pair_delay),
        pointer(system.kept),
        pointer(system.place),
        pointer(system.segment_mode),
        pointer(system.segment_event),
        pointer(system.segment_direction),
        pointer(system.segment_reset),
        pointer(system.segment_to),
        pointer(system.segment_next_way),
        pointer(system.resting),
        pointer(system.segment_repulsion),
        pointer(system.segment_repulsion_case),
        pointer(system.segment_opposite),
        pointer(system.segment_decision_first),
        pointer(system.segment_decision_end),
        system.n_digits,
        system.n_keys,
        pointer(system.leader_digits),
        pointer(system.way_digits),
        pointer(system.option_first),
        pointer(system.option_end),
        pointer(system.is_open),
        pointer(system.number_first),
        pointer(system.decision_size),
        pointer(system.decided),
        pointer(system.rule),
        pointer(system.rule_case),
        pointer(system.digit_first),
        pointer(system.decided_digit),
        pointer(system.crossing_first),
        pointer(system.crossing_segment),
        pointer(system.ending_first),
        pointer(system.ending_segment),
        pointer(system.held_first),
        pointer(system.held_event),
        pointer(system.clock_first),
        pointer(system.clock_event),
        pointer(system.after),
        pointer(system.reads),
        system.chain_order,
        system.chain_n,
        system.section,
        system.section_direction,
        system.stop_event,
        system.stiff,
        pointer(values.p),
        pointer(values.tau),
        pointer(values.event_delay),
        values.max_step,
        values.rtol,
        values.atol,
        values.longest,
        pointer(state.clock),
        pointer(state.count),
        pointer(state.y),
        pointer(state.constant),
        len(state.past_time) - 1,
        pointer(state.past_time),
        pointer(state.past_length),
        pointer(state.past_end),
        pointer(state.past_arc),
        pointer(state.past_shift),
        pointer(state.past_value),
        pointer(state.past_coefficients),
        pointer(state.cursor),
        pointer(state.reading),
        pointer(state.pending_time),
        pointer(state.pending_event),
        pointer(state.pending_shift),
        pointer(state.breaking_time),
        pointer(state.breaking_level),
        pointer(state.accumulation),
        pointer(state.segment_counts),
        pointer(state.side),
        pointer(state.residue),
        pointer(state.next_step),
        pointer(state.resume),
        len(log.time),
        len(log.event_time),
        pointer(log.n),
        pointer(log.time),
        pointer(log.length),
        pointer(log.end),
        pointer(log.mode),
        pointer(log.arc),
        pointer(log.value),
        pointer(log.coefficients),
        pointer(log.event_time),
        pointer(log.event_segment),
        pointer(log.event_arc),
        pointer(log.before),
        pointer(log.after),
        pointer(work.stages),
        pointer(work.extension),
        pointer(work.trial),
        pointer(work.slope),
        pointer(work.xd),
        pointer(work.xd_slope),
        pointer(work.jacobian),
        pointer(work.gradient),
        pointer(work.after_reset),
        pointer(work.past_trial),
        pointer(work.crossing),
        pointer(work.passed),
        pointer(work.found_side),
        pointer(work.bernstein),
        pointer(work.stack),
        pointer(work.digits),
        pointer(work.asked),
        pointer(work.landing),
        system.is_general,
        system.n_values,
        system.n_varying,
        system.n_integrals,
        system.n_turns,
        system.n_first_turns,
        pointer(system.pair_derivative),
        pointer(system.is_rate),
        pointer(system.turn_kind),
        pointer(system.turn_number),
        pointer(system.low),
        pointer(system.high),
        pointer(system.gain),
        system.lags,
        system.integrands,
        pointer(state.past_piece),
        pointer(state.past_level),
        pointer(state.past_size),
        pointer(state.breaking_size),
        pointer(state.lag_time),
        pointer(state.lag_count),
        pointer(work.lag),
        pointer(work.lag_least),
        pointer(work.lag_most),
        pointer(work.held),
        pointer(work.fresh_slope),
        pointer(work.inside),
        pointer(work.integrand),
        pointer(work.panels),
    )

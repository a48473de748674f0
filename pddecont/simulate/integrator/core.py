"""All of an integration as its compiled functions take it."""

from __future__ import annotations

from operator import itemgetter

from pddecont.native.integrator import Core
from pddecont.simulate.integrator.buffers import Log, Workspace
from pddecont.simulate.integrator.state import IntegratorState
from pddecont.simulate.integrator.system import ParameterValues, System

# What the log's arrays are called there, and the numbers of things that no record holds by itself.
LOGGED = (
    *(name if name.startswith("event_") else f"log_{name}" for name in Log._fields[:-2]),
    "event_before",
    "event_after",
)
COUNTED = ("log_steps", "log_events", "mask", "dimension", "n_pairs", "n_delays", "n_kept", "n_segments", "n_events")
GIVEN = (*System._fields, *ParameterValues._fields, *IntegratorState._fields, *Workspace._fields, *LOGGED, *COUNTED)
_in_order = itemgetter(*(GIVEN.index(name) for name in Core._fields))


def make_core(system: System, values: ParameterValues, state: IntegratorState, log: Log, work: Workspace) -> Core:
    """Return an integration by the names of its compiled functions; it shares the arrays, of whatever shape."""
    counted = (
        len(log.time),
        len(log.event_time),
        len(state.past_time) - 1,
        len(state.y),
        len(system.pair_state),
        len(values.tau),
        len(system.kept),
        len(system.segment_mode),
        len(system.after),
    )
    return Core._make(_in_order((*system, *values, *state, *work, *log, *counted)))

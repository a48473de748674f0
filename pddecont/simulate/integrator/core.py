"""All of an integration as its compiled functions take it."""

from __future__ import annotations

from typing import Any

import numpy as np

from pddecont.native.integrator import Core
from pddecont.simulate.integrator.buffers import Log, Workspace
from pddecont.simulate.integrator.state import IntegratorState
from pddecont.simulate.integrator.system import ParameterValues, System


def make_core(system: System, values: ParameterValues, state: IntegratorState, log: Log, work: Workspace) -> Core:
    """Return an integration by the names of its compiled functions; it shares the arrays."""
    fields: dict[str, Any] = {**system._asdict(), **values._asdict(), **state._asdict(), **work._asdict()}
    fields |= {name if name.startswith("event_") else f"log_{name}": part for name, part in log._asdict().items()}
    fields |= {"event_before": log.before, "event_after": log.after, "log_steps": len(log.time)}
    fields |= {"log_events": len(log.event_time), "mask": len(state.past_time) - 1, "dimension": len(state.y)}
    fields |= {"n_pairs": len(system.pair_state), "n_delays": len(values.tau), "n_kept": len(system.kept)}
    fields |= {"n_segments": len(system.segment_mode), "n_events": len(system.after)}
    values_of = map(fields.__getitem__, Core._fields)
    return Core._make(v.reshape(-1) if isinstance(v, np.ndarray) and v.ndim > 1 else v for v in values_of)

"""What Python asks of the compiled integrator, in its own records.

What each function does is said where its source is, under the same name. A status CAPACITY asks for a larger state.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pddecont.native import compiled_integrator as compiled
from pddecont.native.integrator import Returns
from pddecont.simulate.integrator.buffers import Log, ReturnBuffer, Workspace, make_log
from pddecont.simulate.integrator.core import make_core
from pddecont.simulate.integrator.state import IntegratorState
from pddecont.simulate.integrator.system import ParameterValues, System

NOTHING = make_log(0, 0, 0)


def initialise(
    system: System, values: ParameterValues, state: IntegratorState, work: Workspace, t: float, mode: int
) -> None:
    """Begin an integration: :func:`pddecont.native.integrator.advance.initialise`."""
    compiled.initialise(make_core(system, values, state, NOTHING, work), t, mode)


def change_parameters(
    system: System, values: ParameterValues, state: IntegratorState, work: Workspace, before: ParameterValues
) -> None:
    """Let ``values`` hold instead of ``before``: :func:`pddecont.native.integrator.advance.change_parameters`."""
    compiled.change_parameters(make_core(system, values, state, NOTHING, work), before.tau)


def run(
    system: System,
    values: ParameterValues,
    state: IntegratorState,
    log: Log,
    work: Workspace,
    t_stop: float,
    most_steps: int,
) -> int:
    """Integrate to ``t_stop``, and return a status: :func:`pddecont.native.integrator.advance.run`."""
    return compiled.run(make_core(system, values, state, log, work), t_stop, most_steps)


def begin_inside_arc(
    system: System,
    values: ParameterValues,
    state: IntegratorState,
    work: Workspace,
    t: float,
    begin: float,
    mode: int,
    arc: int,
) -> int:
    """Begin where another integration was: :func:`pddecont.native.integrator.restart.begin_inside_arc`."""
    return compiled.begin_inside_arc(make_core(system, values, state, NOTHING, work), t, begin, mode, arc)


def advance_to_return(
    system: System,
    values: ParameterValues,
    state: IntegratorState,
    work: Workspace,
    period: float,
    phase: float,
    t_end: float,
    stop: NDArray[np.float64],
) -> int:
    """Integrate to the next return: :func:`pddecont.native.integrator.poincare.advance_to_return`."""
    return compiled.advance_to_return(make_core(system, values, state, NOTHING, work), period, phase, t_end, stop)


def follow_to_period(
    system: System,
    values: ParameterValues,
    state: IntegratorState,
    work: Workspace,
    returns: ReturnBuffer,
    period: float,
    phase: float,
    t_end: float,
    max_period: int,
) -> tuple[int, int]:
    """Follow a motion until it repeats itself: :func:`pddecont.native.integrator.poincare.follow_to_period`."""
    record = make_returns(system, returns, period)
    core = make_core(system, values, state, NOTHING, work)
    return compiled.follow_to_period(core, record, period, phase, t_end, max_period)


def make_returns(system: System, returns: ReturnBuffer, period: float) -> Returns:
    """Return returns by the names of the compiled functions; they share the arrays."""
    width = returns.states.shape[1]
    return Returns(
        capacity=len(returns.times),
        width=width,
        # At a phase of the forcing the states tell motions apart; at a section they may be the same, and slopes differ.
        n_compared=system.n if period > 0.0 else width,
        n_distances=returns.distances.shape[1],
        n_segments=returns.segment_counts.shape[1],
        size=np.zeros(width),
        noise=np.zeros(width),
        **{name: part.reshape(-1) for name, part in returns._asdict().items()},
    )


def measure_growth(
    system: System,
    values: ParameterValues,
    state: IntegratorState,
    work: Workspace,
    interval: float,
    logs: NDArray[np.float64],
    done: NDArray[np.float64],
) -> int:
    """Write how the tangent grows to ``logs``: :func:`pddecont.native.integrator.tangent_growth.measure_growth`."""
    return compiled.measure_growth(make_core(system, values, state, NOTHING, work), interval, len(logs), logs, done)

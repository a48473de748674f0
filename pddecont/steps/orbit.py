"""The ``orbit`` step: the periodic orbit that a trajectory has settled to, or a recorded orbit solved anew."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ConvergenceError, SignatureError
from pddecont.orbit.admissibility import objections
from pddecont.orbit.breaking import jumps_at_events
from pddecont.orbit.curve import settle
from pddecont.orbit.error import rounding_error
from pddecont.orbit.guess import orbit_from_cycle
from pddecont.orbit.monitors import parse_monitor
from pddecont.orbit.problem import OrbitProblem
from pddecont.results.writer import StepWriter
from pddecont.simulate.recognise import recognise
from pddecont.simulate.trajectory import Trajectory
from pddecont.stability.multipliers import describe
from pddecont.steps.context import Context, attractor_step, choice_of, known_multipliers, mesh_settings, orbit_at, settings_text
from pddecont.steps.points import orbit_row, orbit_spec
from pddecont.steps.schema import Step
from pddecont.steps.units import units_of

Array = NDArray[np.float64]
POOR = 1e-3
ROUNDING = 1e-10


def first_guess(context: Context, step: Step) -> tuple[OrbitProblem, Array]:
    """Return the problem and the first guess of an orbit step."""
    body, plan = step.orbit, context.plan
    assert body is not None
    source = body.from_
    above = {s.name: s for s in plan.run.steps}
    if source.file is None and above[source.step].kind == "simulate":
        trajectory, p = _trajectory(context, above[source.step])
    elif attractor_step(context, source) is not None:
        trajectory, p = _from_attractor(context, step)
    else:
        return orbit_at(context, step, source)
    cycle = recognise(plan.numeric, p, trajectory)
    p = plan.step_parameters(step, p)
    return orbit_from_cycle(plan.numeric, p, plan.delay_method(step), cycle, context.rule_of(step))


def _trajectory(context: Context, source: Step) -> tuple[Trajectory, Array]:
    """Return the trajectory of a simulate step and the parameters at its end."""
    from pddecont.steps.simulate import integrate

    return integrate(context, source), context.trajectories[source.name][1]


def _from_attractor(context: Context, step: Step) -> tuple[Trajectory, Array]:
    """Return a few periods of the attractor that a step starts from, and its parameters."""
    from pddecont.steps.restart import attractor_trajectory

    assert step.orbit is not None
    return attractor_trajectory(context, step, step.orbit.from_)


def run_orbit(context: Context, step: Step) -> None:
    """Correct the guess to a periodic orbit and record it."""
    plan = context.plan
    assert step.orbit is not None
    problem, guess = first_guess(context, step)
    names = [s.name for s in problem.segments]
    if step.orbit.signature is not None and not is_rotation(names, step.orbit.signature):
        raise SignatureError(f"the orbit runs through [{', '.join(names)}], not through the signature "
                             f"[{', '.join(step.orbit.signature)}] that step '{step.name}' asks for")  # fmt: skip
    try:
        problem, solution = settle(problem, guess, context.rule_of(step))
    except ConvergenceError as exc:
        rounding = rounding_error(problem, guess)
        magnified = "" if rounding < ROUNDING else (f" The chain magnifies rounding errors to {rounding:.0e} of the orbit's size here: "
                                                    "lower its order or 'n', or use a coarser mesh or the direct method.")  # fmt: skip
        raise ConvergenceError(f"step '{step.name}': no periodic orbit near the guess with signature [{', '.join(names)}]: {exc}. "
                               "What usually helps: a longer transient (raise 't_end'), a finer mesh, "
                               f"parameters farther from a grazing.{magnified}", exc.history) from exc  # fmt: skip
    monitors = [parse_monitor(plan.numeric, name, text) for name, text in plan.monitors.items()]
    meta = {"settings": settings_text(plan, step), "mesh_settings": mesh_settings(plan, step), "units": units_of(plan),
            **choice_of(plan, step)}  # fmt: skip
    spec = orbit_spec(step.name, "orbit", plan.numeric, monitors, meta)
    known = known_multipliers(step.orbit.stability)
    stability = None if known is None else known(problem, solution.x)
    points, rows = orbit_row(problem, solution.x, monitors, n_iterations=solution.n_iterations, stability=stability)
    text = (f"converged in {solution.n_iterations} Newton iterations to signature [{' '.join(names)}], "
            f"period {problem.period(solution.x):.10g}")  # fmt: skip
    if points["error_estimate"] > POOR:
        text += (f"; WARNING: its estimated error is {points['error_estimate']:.1e}: refine 'mesh', and with a chain of order 3 or "
                 "more lower 'n' (it magnifies rounding errors)")  # fmt: skip
    if stability is not None:
        text += f"; {describe(stability)}"
        if jumps_at_events(plan.numeric, problem.segments, problem.theta(solution.x)):
            text += ("; WARNING: a jump of the state comes back through a delay just at an event: nearby motions read it before or "
                     "after, and have other multipliers on either side")  # fmt: skip
    against = objections(problem, solution.x)
    if against:
        text += f"; not admissible: {against[0]}"
    with StepWriter(context.path, spec, capacity=1) as writer:
        writer.append(points, rows)
        writer.terminate(text)
    context.reporter.done(text)


def is_rotation(a: Sequence[str], b: Sequence[str]) -> bool:
    """Whether two signatures are the same up to where they begin."""
    return len(a) == len(b) and any(list(a) == [*b[i:], *b[:i]] for i in range(max(len(b), 1)))

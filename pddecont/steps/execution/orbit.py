"""Doing an ``orbit`` step."""

from __future__ import annotations

from typing import Any

from pddecont.delay import jump_returns_at_event
from pddecont.errors import ConvergenceError, SignatureError
from pddecont.orbit import (
    Orbit,
    Verifier,
    count_repetitions,
    estimate_rounding_error,
    find_free_states,
    find_violation,
    guess_from_cycle,
    is_at_rest,
    is_rotation,
    solve_within_tolerance,
)
from pddecont.reasons import Reason, Scalar
from pddecont.results import ORBIT, Step
from pddecont.runfile import Holding, PlannedStep, Source
from pddecont.simulate import detect_period
from pddecont.stability import Multipliers
from pddecont.steps.context import Context
from pddecont.steps.execution.ending import report_done
from pddecont.steps.execution.orbit_rows import make_multiplier_cache, make_orbit_meta, make_referee, orbit_to_row
from pddecont.steps.execution.recorded_orbits import find_orbit
from pddecont.steps.orbit import OrbitSettings
from pddecont.steps.registry import list_step_kinds

# Rounding errors above this part of an orbit's size are worth a word when it does not converge.
ROUNDING = 1e-10
# Newton's method stops without a solution although the equations hold to this where the solution is not unique.
SMALL = 1e-6
# Multipliers whose values are told when the step is done.
N_TOLD = 2


def make_guess(context: Context, step: PlannedStep[Any]) -> Orbit:
    """Return the first guess of an orbit: from a file, a simulation, an attractor, a recorded orbit."""
    plan = context.plan
    if step.settings.cycle is not None:
        p = plan.set_parameters(step, plan.parameters)
        return guess_from_cycle(plan.numeric, p, step.delay, step.settings.cycle, step.rule)
    source = _source_of(step)
    kinds = list_step_kinds()
    above = None if source.file is not None else plan.find_step(source.step)
    if above is not None and kinds[above.kind].holds == Holding.TRAJECTORY:
        # What simulates is imported by runs that simulate, and by no others.
        from pddecont.steps.execution.simulate import find_trajectory

        trajectory, p = find_trajectory(context, above), above.settings.last_parameters
    else:
        recorded = context.read_source(source)[1]
        if kinds[recorded.kind].holds != Holding.ATTRACTORS:
            return find_orbit(context, step, source)
        from pddecont.steps.execution.attractor_restart import continue_attractor

        trajectory, p = continue_attractor(context, recorded, source)
    cycle = detect_period(plan.numeric, p, trajectory)
    return guess_from_cycle(plan.numeric, plan.set_parameters(step, p), step.delay, cycle, step.rule)


def _source_of(step: PlannedStep[Any]) -> Source:
    assert step.source is not None, "an orbit step's schema has a source"
    return step.source


def run_orbit(context: Context, step: PlannedStep[OrbitSettings], recorded: Step | None) -> None:
    """Correct the guess to a periodic orbit and record it."""
    plan = context.plan
    guess = make_guess(context, step)
    names, asked = guess.signature.names, step.settings.signature
    if asked is not None and not is_rotation(names, asked):
        raise SignatureError(
            f"the orbit runs through [{', '.join(names)}], not through the signature [{', '.join(asked)}] that step "
            f"'{step.name}' asks for"
        )
    try:
        solution, error = solve_within_tolerance(guess, step.rule)
    except ConvergenceError as exc:
        raise ConvergenceError(_explain_failure(step, guess, exc), exc.history) from exc
    orbit = solution.at.orbit
    if step.files:
        _check_found(step, guess, orbit)
    cache = make_multiplier_cache(step.settings.multipliers)
    multipliers = None if cache is None else cache.find(orbit)
    monitors = list(plan.monitors.values())
    referee = make_referee(plan, step)
    meta = make_orbit_meta(plan, step)
    points, rows = orbit_to_row(
        orbit,
        monitors,
        meta["events"],
        n_iterations=solution.n_iterations,
        multipliers=multipliers,
        n_shown=step.settings.multipliers.number,
        referee=referee,
        error=error,
    )
    with context.open_step(step, ORBIT, meta, capacity=1) as writer:
        writer.append(points, rows)
        writer.terminate(_make_ending(orbit, multipliers, referee))
    report_done(context, step)


def _check_found(step: PlannedStep[OrbitSettings], guess: Orbit, orbit: Orbit) -> None:
    """Raise ConvergenceError if what is found near the motion of a file is no orbit, or one several times over."""
    where = f"step '{step.name}': what Newton's method finds near {', '.join(step.files)}"
    if is_at_rest(orbit, guess):
        raise ConvergenceError(
            f"{where} is an equilibrium and no periodic orbit. What usually helps: rows nearer to the orbit, the "
            "parameters that they were computed at ('set'); an 'equilibrium' step finds equilibria"
        )
    n = count_repetitions(orbit)
    if n > 1:
        raise ConvergenceError(
            f"{where} is an orbit of period {orbit.period / n:.10g}, {n} times over. Give the rows of one of its "
            "periods, or rows nearer to another orbit"
        )


def _explain_failure(step: PlannedStep[OrbitSettings], guess: Orbit, exc: ConvergenceError) -> str:
    free = find_free_states(guess) if exc.history and min(exc.history) < SMALL else ()
    if free:
        return (
            f"step '{step.name}': no periodic orbit near the guess with signature "
            f"[{', '.join(guess.signature.names)}] can be singled out and followed, for it is one of a family: at "
            f"these parameters its equations hold and leave {', '.join(free)} free. What usually helps: a model in "
            "which a conserved quantity is a parameter, or in which it decays"
        )
    rounding = estimate_rounding_error(guess)
    magnified = ""
    if rounding >= ROUNDING:
        magnified = (
            f" The chain magnifies rounding errors to {rounding:.0e} of the orbit's size here: lower its order or 'n', "
            "or use a coarser mesh or the direct method."
        )
    nearer = (
        "more rows or digits, the parameters that the rows were computed at ('set')"
        if step.files
        else "a longer transient (raise 't_end')"
    )
    return (
        f"step '{step.name}': no periodic orbit near the guess with signature [{', '.join(guess.signature.names)}]: "
        f"{exc}. What usually helps: {nearer}, a finer mesh, "
        f"parameters farther from a grazing.{magnified}"
    )


def _make_ending(orbit: Orbit, multipliers: Multipliers | None, referee: Verifier | None) -> Reason:
    """Return how the step ended: leading multipliers, what makes them doubtful, why it is no motion of the model."""
    values: dict[str, Scalar] = {"multipliers": multipliers is not None}
    if multipliers is not None:
        for k, z in enumerate(multipliers.nontrivial[:N_TOLD].tolist(), 1):
            values |= {f"re{k}": z.real, f"im{k}": z.imag}
        values |= {} if multipliers.counted else {"uncounted": True}
        values["jump_returns_at_event"] = jump_returns_at_event(
            orbit.signature.discontinuity_sources, orbit.theta, len(orbit.signature)
        )
    violation = find_violation(orbit, referee)
    if referee is not None and referee.verify(orbit).verified < 0:
        values["not_verified"] = referee.verify(orbit).reason.code
    if violation:
        values |= {"detail": violation.code, **violation.values}
    return Reason("converged", values)

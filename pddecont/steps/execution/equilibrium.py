"""Doing an ``equilibrium`` step."""

from __future__ import annotations

import contextlib
from dataclasses import replace

import numpy as np

from pddecont.equilibrium import (
    ConstantMotion,
    Equilibrium,
    FoundEquilibrium,
    find_delayed_switchings,
    find_own_roots,
    find_passed_side,
    read_mode,
    solve_equilibrium,
)
from pddecont.errors import ConvergenceError, ResultsError
from pddecont.reasons import NO_REASON, make_reason
from pddecont.results import EQUILIBRIUM, Step
from pddecont.runfile import Holding, PlannedStep
from pddecont.steps.context import Context
from pddecont.steps.equilibrium import EquilibriumSettings
from pddecont.steps.execution.ending import report_done
from pddecont.steps.execution.equilibrium_rows import (
    add_doubts,
    equilibrium_from_row,
    equilibrium_to_row,
    make_equilibrium_meta,
)
from pddecont.steps.execution.equilibrium_search import (
    list_switchings,
    make_search_meta,
    make_switching_meta,
    search_box,
)
from pddecont.steps.registry import list_step_kinds
from pddecont.tables import describe_switchings

# What a row of an equilibrium step is.
EQUILIBRIUM_KIND = "EQ"
KINDS = {EQUILIBRIUM_KIND: "equilibrium"}
# Modes in which an equilibrium is looked for that lies in its mode, at most.
MODES_TRIED = 50


def run_equilibrium(context: Context, step: PlannedStep[EquilibriumSettings], recorded: Step | None) -> None:
    """Find and record the equilibria that a step asks for."""
    settings, meta = step.settings, make_equilibrium_meta(context.plan, step, KINDS)
    if settings.box is None:
        guess = _make_guess(context, step)
        guess = guess if settings.mode is None else replace(guess, motion=replace(guess.motion, mode=settings.mode))
        found = [FoundEquilibrium(*_find_near(step, guess))]
        meta |= make_switching_meta(find_delayed_switchings(guess))
        ending = make_reason("equilibrium")
    else:
        findings = search_box(context, step)
        found, meta = findings.equilibria, meta | make_search_meta(step, findings)
        meta |= make_switching_meta(list_switchings(context, step))
        ending = make_reason("search")
    monitors = list(context.plan.monitors.values())
    with context.open_step(step, EQUILIBRIUM, meta, capacity=max(len(found), 1)) as writer:
        for one in found:
            at = one.at
            roots = find_own_roots(at.motion, at.states, at.parameters, settings.n_roots)
            points, rows = equilibrium_to_row(
                at,
                roots,
                monitors,
                unknowns=at.states,
                kind=EQUILIBRIUM_KIND,
                error=one.error,
                n_iterations=one.n_iterations,
            )
            writer.append(points, rows, add_doubts(NO_REASON, at, roots))
        writer.terminate(ending)
    report_done(context, step)


def _find_near(step: PlannedStep[EquilibriumSettings], guess: Equilibrium) -> tuple[Equilibrium, float, int]:
    """Return the equilibrium near a guess; where no mode is asked for, in the mode that holds there."""
    try:
        found = solve_equilibrium(guess)
        if step.settings.mode is None and find_passed_side(found[0]) is not None:
            found = _find_in_other_mode(found[0]) or found
        _check_lags(found[0])
    except ConvergenceError as exc:
        between = make_switching_meta(find_delayed_switchings(guess))["switchings"]
        switchings = describe_switchings(guess.motion.numeric.model.states, between)
        raise ConvergenceError(
            f"step '{step.name}': no equilibrium near the guess in mode '{guess.motion.mode}': {exc}{switchings}. What "
            "usually helps: a guess from a simulation that has come to rest, another 'mode', or 'search' in a box",
            exc.history,
        ) from exc
    return found


def _check_lags(at: Equilibrium) -> None:
    """Raise ConvergenceError where a delay is negative at rest."""
    negative = at.motion.find_negative_lag(at.states, at.parameters)
    if negative is not None:
        places = zip(at.motion.numeric.model.states, at.states.tolist(), strict=True)
        where = ", ".join(f"{name} = {value:.8g}" for name, value in places)
        raise ConvergenceError(
            f"at rest, {where}, the delay '{negative[0]}' is {negative[1]:.6g}: it would read the future"
        )


def _find_in_other_mode(virtual: Equilibrium) -> tuple[Equilibrium, float, int] | None:
    """Return an equilibrium that lies in its mode, near a virtual one of a neighbouring mode; None if there is none."""
    model = virtual.motion.numeric.model
    tried, ahead = {virtual.motion.mode}, [read_mode(virtual)]
    ahead += [s.to for s in model.list_segments(virtual.motion.mode)]
    while ahead and len(tried) < MODES_TRIED:
        mode = ahead.pop(0)
        if mode in tried:
            continue
        tried.add(mode)
        with contextlib.suppress(ConvergenceError):
            found = solve_equilibrium(replace(virtual, motion=replace(virtual.motion, mode=mode)))
            if find_passed_side(found[0]) is None:
                return found
        ahead += [s.to for s in model.list_segments(mode)]
    return None


def _make_guess(context: Context, step: PlannedStep[EquilibriumSettings]) -> Equilibrium:
    plan, source = context.plan, step.source
    if source is None:
        p = plan.set_parameters(step, plan.parameters)
        values = plan.name_values(p)
        states = np.array(
            [
                step.settings.guess[name].evaluate(values)
                if name in step.settings.guess
                else plan.model.evaluate(e, values, 0.0)
                for name, e in zip(plan.model.states, plan.model.history, strict=True)
            ]
        )
        motion = ConstantMotion(plan.numeric, plan.model.initial_mode, step.delay)
        guess = Equilibrium(motion, states, p)
        return replace(guess, motion=replace(motion, mode=read_mode(guess)))
    above = None if source.file is not None else plan.find_step(source.step)
    if above is not None and list_step_kinds()[above.kind].holds == Holding.TRAJECTORY:
        # What simulates is imported by runs that simulate, and by no others.
        from pddecont.steps.execution.simulate import find_trajectory

        trajectory = find_trajectory(context, above)
        p = plan.set_parameters(step, above.settings.last_parameters)
        _, states, modes = trajectory.sample()
        return Equilibrium(ConstantMotion(plan.numeric, modes[-1], step.delay), states[-1], p)
    recorded, row = find_equilibrium(context, step)
    at = equilibrium_from_row(plan, step.delay, recorded, row)
    return replace(at, parameters=plan.set_parameters(step, at.parameters))


def find_equilibrium(context: Context, step: PlannedStep[object]) -> tuple[Step, int]:
    """Return the recorded step of equilibria that a step starts from, and the row of its point.

    Raises
    ------
    ResultsError
        If it holds none, or several and none is named.
    """
    source = step.source
    assert source is not None, "only asked of steps that start from one"
    results, recorded = context.read_source(source)
    if "roots" not in recorded.format.orbits:
        raise ResultsError(f"step '{source.step}' of {results.path} is a {recorded.kind} step and holds no equilibria")
    if not len(recorded):
        raise ResultsError(f"step '{source.step}' of {results.path} found no equilibrium: search in another box")
    if source.point is None and source.index is None and len(recorded) > 1:
        labels = ", ".join(label for label in recorded.labels if label)
        raise ResultsError(
            f"step '{source.step}' holds {len(recorded)} equilibria ({labels}); say which: "
            f"{{step: {source.step}, point: {recorded.labels[0] or 'EQ1'}}}"
        )
    row = recorded.row(source.point) if source.point else source.index or 0
    if row >= len(recorded):
        raise ResultsError(f"step '{source.step}' of {results.path} has {len(recorded)} points, no index {row}")
    return recorded, row

"""The problems of steps that simulate: where motions start, how long they last, where their returns are counted."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Protocol

from pddecont.errors import suggest
from pddecont.model.expression import ExpressionError, parse
from pddecont.model.starts import beyond_an_event
from pddecont.model.system import Model
from pddecont.steps.lengths import wrong_lengths
from pddecont.steps.plan import as_number
from pddecont.steps.schema import Basin, Initial, Integration, RunBlock, Step, Sweep

Path = tuple[str | int, ...]
# What one step may hold at most: samples of a trajectory, motions of a sweep, cells of a basin.
MAX_SAMPLES, MAX_MOTIONS, MAX_CELLS = 100_000_000, 2_000_000, 25_000_000


class Checker(Protocol):
    """Who collects problems: a planner."""

    model: Model
    run: RunBlock

    def complain(self, path: Sequence[str | int], message: str, *, offset: int = 0, key: bool = False) -> None:
        """Note a problem at a place in the run."""
        ...

    def warn(self, path: Sequence[str | int], message: str) -> None:
        """Note a warning at a place in the run."""
        ...

    def check_settable(self, path: Sequence[str | int], name: str, values: Mapping[str, float], *, key: bool = True) -> bool:
        """Check that a name is a parameter that can be given a value."""
        ...

    def formula(self, path: Sequence[str | int], text: str | float, values: Mapping[str, float]) -> float:
        """Return the number that a formula stands for; note a problem where it stands for none."""
        ...


def check_simulate(planner: Checker, path: Path, step: Step, values: Mapping[str, float]) -> None:
    """Check a simulate step."""
    assert step.simulate is not None
    body = step.simulate
    t_end = positive_time(planner, (*path, "t_end"), body.t_end, values)
    check_initial(planner, (*path, "initial"), body.initial, values)
    check_start(planner, path, body.initial, values)
    check_integration(planner, path, step, body, values)
    later = dict(values)
    times = {text: planner.formula((*path, "at", text), as_number(text), values) for text in body.at}
    for text, time in sorted(times.items(), key=lambda pair: pair[1]):
        here, changes = (*path, "at", text), body.at[text]
        if not 0 < time < t_end:
            planner.complain(here, f"the time {time:g} does not lie between 0 and t_end, {t_end:g}", key=True)
        for name, value in changes.items():
            if planner.check_settable((*here, name), name, values):
                later[name] = planner.formula((*here, name), value, later)
        check_parameters(planner, here, later)
    since = planner.formula((*path, "record", "from"), body.record.from_, values)
    if not 0 <= since < t_end:
        planner.complain((*path, "record", "from"), f"the time {since:g} does not lie between 0 and t_end, {t_end:g}")
    scope = planner.model.scope("a signal", delayed=planner.model.delayed_value)
    for name, formula in body.record.signals.items():
        here = (*path, "record", "signals", name)
        if name in planner.model.states:
            planner.complain(here, f"'{name}' is a state already; give the signal another name", key=True)
        try:
            expr = parse(formula, scope)
        except ExpressionError as exc:
            planner.complain(here, str(exc), offset=exc.offset)
            continue
        if (step.delay or planner.run.delay).method == "chain" and expr.free_symbols & set(planner.model.delayed_symbols):
            planner.complain(here, "a chain has no delayed values of its own to record; give this step 'delay: {method: direct}'")
    if body.record.every is not None:
        every = positive_time(planner, (*path, "record", "every"), body.record.every, values)
        if (t_end - since) / every > MAX_SAMPLES:
            planner.complain((*path, "record", "every"), f"more than {MAX_SAMPLES} samples; take longer times between them")


def check_parameters(planner: Checker, path: Path, values: Mapping[str, float]) -> None:
    """Check that delays and the forcing period are what they can be at some parameters."""
    for message, _ in wrong_lengths(planner.model, values):
        planner.complain(path, message)


def positive_time(planner: Checker, path: Path, text: str | float, values: Mapping[str, float]) -> float:
    """Return a time, and check that it is positive."""
    time = planner.formula(path, text, values)
    if time <= 0:
        planner.complain(path, f"{path[-1]} is {time:g}; expected a positive time")
    return time


def check_initial(planner: Checker, path: Path, initial: Initial, values: Mapping[str, float]) -> None:
    """Check where a motion starts."""
    if initial.mode is not None and initial.mode not in planner.model.modes:
        planner.complain((*path, "mode"), f"mode '{initial.mode}' is not defined (modes: {', '.join(planner.model.modes)})")
    # A state that an effect took along may still be given: what it begins with means nothing then.
    states = [*planner.model.states, *planner.model.left_out.reasons.get("states", ())]
    for name, text in initial.states.items():
        if name not in states:
            planner.complain((*path, name), f"'{name}' is not a state{suggest(name, states)}", key=True)
        else:
            planner.formula((*path, name), text, values)
    if not isinstance(initial.history, Mapping):
        return
    for name, text in initial.history.items():
        here = (*path, "history", name)
        if name not in states:
            planner.complain(here, f"'{name}' is not a state{suggest(name, states)}", key=True)
        try:
            parse(text, planner.model.history_scope())
        except ExpressionError as exc:
            planner.complain(here, str(exc), offset=exc.offset)


def check_start(planner: Checker, path: Path, initial: Initial, values: Mapping[str, float]) -> None:
    """Warn of a motion that starts beyond an event that ends its mode."""
    model = planner.model
    if isinstance(initial.history, Mapping):
        return
    try:
        states = [model.evaluate(parse(initial.states[s], model.parameter_scope("a run file")), values) if s in initial.states
                  else model.evaluate(e, values, 0.0) for s, e in zip(model.states, model.history, strict=True)]  # fmt: skip
    except ExpressionError:
        return
    message = beyond_an_event(model, initial.mode or model.initial_mode, states, values)
    if message:
        planner.warn((*path, "initial") if initial.states else path, message)


def check_integration(planner: Checker, path: Path, step: Step, body: Integration, values: Mapping[str, float]) -> None:
    """Check how a step integrates."""
    for event, mode in body.stick.items():
        if event not in planner.model.events:
            hint = planner.model.hint("events", event, planner.model.events)
            planner.complain((*path, "stick", event), f"'{event}' is not an event{hint}", key=True)
        if mode not in planner.model.modes:
            planner.complain((*path, "stick", event), f"mode '{mode}' is not defined{suggest(mode, planner.model.modes)} "
                                                   f"(modes: {', '.join(planner.model.modes)})")  # fmt: skip
    if body.max_step is not None:
        positive_time(planner, (*path, "max_step"), body.max_step, values)
    delay = step.delay or planner.run.delay
    if delay.method == "chebyshev":
        planner.complain(path, "trajectories are computed with the delay itself or the chain, not with a Chebyshev delay line; give this "
                            "step 'delay: {method: direct}'", key=True)  # fmt: skip


def check_settling(planner: Checker, path: Path, step: Step, body: Sweep | Basin, values: Mapping[str, float]) -> None:
    """Check what sweeps and basins have in common."""
    check_integration(planner, path, step, body, values)
    positive_time(planner, (*path, "transient"), body.transient, values)
    if body.lyapunov and body.stick:
        planner.complain((*path, "lyapunov"), "what neighbouring motions do where events accumulate is not followed: Lyapunov exponents "
                                           "do not go with 'stick'")  # fmt: skip
    if body.lyapunov and body.method == "stiff":
        planner.complain((*path, "lyapunov"), "Lyapunov exponents go with the explicit method; leave 'method: stiff' out")
    section = body.section
    if (section is None or section.phase is not None) and not planner.model.forced:
        events = next(iter(planner.model.events), None)
        example = f"{{event: {events}}}" if events else f"{{zero: {planner.model.states[0]} - 1}}"
        why = planner.model.left_out.hint("forcing", "period")
        planner.complain((*path, "section") if section else path, f"the model has no forcing whose periods could count returns{why}; say "
                      f"where they are counted: 'section: {example}'", key=section is None)  # fmt: skip
    if section is not None and section.event is not None and section.event not in planner.model.events:
        hint = planner.model.hint("events", section.event, planner.model.events)
        planner.complain((*path, "section", "event"), f"'{section.event}' is not an event{hint} "
                                                   f"(events: {', '.join(planner.model.events) or 'none'})")  # fmt: skip
    if section is not None and section.zero is not None:
        try:
            parse(section.zero, planner.model.scope("a section"))
        except ExpressionError as exc:
            planner.complain((*path, "section", "zero"), str(exc), offset=exc.offset)
    for name, (low, high, n) in body.over.items():
        here = (*path, "over", name)
        ends = [planner.formula((*here, k), text, values) for k, text in enumerate((low, high))]
        if ends[0] > ends[1] or (ends[0] == ends[1] and n != 1):
            planner.complain(here, f"the range is empty: {ends[0]:g} is not below {ends[1]:g}")


def check_sweep(planner: Checker, path: Path, step: Step, values: Mapping[str, float]) -> None:
    """Check a sweep step."""
    body = step.sweep
    assert body is not None
    check_settling(planner, path, step, body, values)
    for name in body.over:
        if not planner.check_settable((*path, "over", name), name, values):
            return
    names = list(body.over)
    for ends in itertools.product(*(body.over[name][:2] for name in names)):
        corner = {name: planner.formula((*path, "over", name), end, values) for name, end in zip(names, ends, strict=True)}
        check_parameters(planner, (*path, "over"), {**values, **corner})
    scattered = body.random.number if body.random else 0
    motions = math.prod(int(n) for _, _, n in body.over.values()) * (scattered + len(body.initial))
    if motions > MAX_MOTIONS:
        planner.complain((*path, "over"), f"{motions} motions in one step; at most {MAX_MOTIONS}: make it several steps")
    for i, initial in enumerate(body.initial):
        check_initial(planner, (*path, "initial", i), initial, values)
        histories = initial.history, body.initial[0].history
        if any(isinstance(h, Mapping) for h in histories) and histories[0] != histories[1]:
            planner.complain((*path, "initial", i), "all initial states of a sweep share one history; give other histories a step of "
                                                 "their own")  # fmt: skip
    for name, limits in body.random.box.items() if body.random else ():
        here = (*path, "random", "box", name)
        if name not in planner.model.states:
            planner.complain(here, f"'{name}' is not a state{suggest(name, planner.model.states)}", key=True)
        low, high = (planner.formula((*here, k), text, values) for k, text in enumerate(limits))
        if low > high:
            planner.complain(here, f"the range is empty: {low:g} is not below {high:g}")


def check_basin(planner: Checker, path: Path, step: Step, values: Mapping[str, float]) -> None:
    """Check a basin step."""
    body = step.basin
    assert body is not None
    check_settling(planner, path, step, body, values)
    check_initial(planner, (*path, "initial"), body.initial, values)
    cells = math.prod(int(n) for _, _, n in body.over.values())
    if cells > MAX_CELLS:
        planner.complain((*path, "over"), f"{cells} initial states in one step; at most {MAX_CELLS}")
    for name in body.over:
        if name not in planner.model.states:
            planner.complain((*path, "over", name), f"'{name}' is not a state{suggest(name, planner.model.states)} "
                                                 f"(states: {', '.join(planner.model.states)})", key=True)  # fmt: skip
        elif name in body.initial.states:
            planner.complain((*path, "initial", name), f"'{name}' varies over the grid and cannot be given too", key=True)

"""Equations with nonsmooth functions, as a file writes them, in symbols: field, switches and jumps."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import sympy

from pddecont.errors import suggest
from pddecont.model.expression import TIME, Scope
from pddecont.model.findings import Findings
from pddecont.model.lagged import make_symbol
from pddecont.model.nonsmooth import Clock, SwitchCollector
from pddecont.model.schema import Jump as JumpBody
from pddecont.model.schema import ModelFile
from pddecont.model.switches import Equations, Jump, Switch

# What hand-written models have, and models given by equations have not.
BY_HAND = ("modes", "events", "resets", "segments")
# Signs of switches in a file.
SIGNS: Mapping[str, sympy.Expr] = {"-": sympy.S.Zero, "+": sympy.S.One, "0": sympy.Rational(1, 2)}


def check_kind(file: ModelFile, findings: Findings) -> None:
    """Check that a file gives its modes or its equations, and not parts of both."""
    if file.equations:
        for key in BY_HAND:
            if getattr(file, key):
                findings.add_error(
                    (key,),
                    f"'{key}' belongs to models written by hand; this one gives 'equations', of which modes are made",
                    key=True,
                )
        return
    if not file.modes:
        findings.add_error((), "a model needs 'equations' ({x': expression}) or 'modes'; add one of them")
    for key in ("switches", "jumps"):
        if getattr(file, key):
            findings.add_error((key,), f"'{key}' belongs to models that give 'equations'", key=True)


def declare_switches(
    file: ModelFile, scope_with: Callable[[str | float, str], Scope], collector: SwitchCollector, findings: Findings
) -> None:
    """Give the switches that a file names their names, before expressions are read that share their arguments.

    ``scope_with(text, place)`` is the scope of a text that reads definitions.
    """
    for name, text in file.switches.items():
        with findings.noting(("switches", name)):
            argument = findings.expression(("switches", name), text, scope_with(text, "a switch"))
            collector.declare(name, argument)


def read_equations(
    file: ModelFile, scope: Scope, collector: SwitchCollector, findings: Findings, delays: Mapping[str, sympy.Expr]
) -> Equations:
    """Return what a file's equations say; ``delays`` are those of its delayed jumps.

    ``scope`` has the functions of ``collector`` among its builtins.
    """
    states = tuple(map(make_symbol, file.states))
    field = tuple(
        findings.expression(("equations", key), text, scope) if text is not None else sympy.S.Zero
        for key, text in findings.body(("equations",), file.equations, file.states, "the model")
    )
    jumps = tuple(_read_jump(name, jump, file, scope, collector, findings, delays) for name, jump in file.jumps.items())
    switches = tuple(collector.switches)
    digits = [s.digit for s in switches]
    _check_names(file, switches, findings)
    clocks = tuple(collector.clocks.values())
    equations = Equations(
        states,
        tuple(make_multilinear(f, digits) for f in field),
        tuple(replace(s, argument=make_multilinear(s.argument, digits)) for s in switches),
        jumps,
    ).add_states(tuple(c.state for c in clocks), tuple(sympy.S.One for _ in clocks))
    for clock in clocks:
        equations = _let_tick(equations, clock)
    used = equations.leave_out_idle()
    for name in file.switches:
        if name not in {s.name for s in used.switches}:
            findings.add_warning(("switches", name), f"no nonsmooth function reads the sign of switch '{name}'")
    return used


def _let_tick(equations: Equations, clock: Clock) -> Equations:
    """Return the equations with a clock that is set to zero by a jump of its own, or by one that comes as it ticks."""
    states, jumps = equations.states, list(equations.jumps)
    at_once = (k for k, j in enumerate(jumps) if (j.function, j.direction, j.when) == (clock.tick, "rising", 1))
    place = next(at_once, len(jumps))
    if place == len(jumps):
        jumps.append(Jump(f"{clock.state.name}_tick", clock.tick, "rising", None, None, states))
    reset = zip(states, jumps[place].reset, strict=True)
    jumps[place] = replace(jumps[place], reset=tuple(sympy.S.Zero if x == clock.state else g for x, g in reset))
    return replace(equations, jumps=tuple(jumps))


def make_multilinear(expr: sympy.Expr, digits: list[sympy.Symbol]) -> sympy.Expr:
    """Return what an expression is with digits 0 and 1, linear in each digit: between them it is Filippov's mean."""
    for digit in digits:
        if digit in expr.free_symbols and (slope := expr.diff(digit)) != 0 and digit in slope.free_symbols:
            below, above = expr.xreplace({digit: sympy.S.Zero}), expr.xreplace({digit: sympy.S.One})
            expr = below + digit * (above - below)
    return expr


def _read_jump(
    name: str,
    body: JumpBody,
    file: ModelFile,
    scope: Scope,
    collector: SwitchCollector,
    findings: Findings,
    delays: Mapping[str, sympy.Expr],
) -> Jump:
    path = ("jumps", name)
    function, direction = None, body.direction
    if body.at is not None:
        function = findings.expression((*path, "at"), body.at, scope)
    elif body.every is not None:
        period = findings.expression((*path, "every"), body.every, scope)
        function, direction = sympy.sin(2 * sympy.pi * TIME / period), "rising"
    elif body.after not in {*file.jumps, *file.switches}:
        known = [*file.jumps, *file.switches]
        findings.add_error(
            (*path, "after"), f"'{body.after}' is no jump and no named switch{suggest(str(body.after), known)}"
        )
    elif body.after == name:
        findings.add_error((*path, "after"), f"jump '{name}' cannot come after itself")
    findings.check_reset(path, body.reset, file.states, f"jump '{name}'")
    reset = tuple(
        findings.expression((*path, "reset", s), body.reset[s], scope) if s in body.reset else make_symbol(s)
        for s in file.states
    )
    when = sympy.S.One
    if body.when is not None:
        n_problems = len(findings.problems)
        condition = findings.condition((*path, "when"), body.when, scope)
        with findings.noting((*path, "when")):
            when = collector.weigh(condition) if len(findings.problems) == n_problems else when
    named = {s.name: s.digit for s in collector.switches}
    for switch, sign in body.only.items():
        if switch not in named:
            findings.add_error((*path, "in", switch), f"'{switch}' is no switch{suggest(switch, named)}", key=True)
            continue
        h, wanted = named[switch], SIGNS[sign]
        # 1 at the wanted digit, 0 at the two others.
        others = [v for v in SIGNS.values() if v != wanted]
        when *= sympy.Mul(*((h - v) / (wanted - v) for v in others))
    return Jump(name, function, direction, body.after, delays.get(name), reset, when, body.rest)


def _check_names(file: ModelFile, switches: tuple[Switch, ...], findings: Findings) -> None:
    """Check that what a file names is used, and nothing twice."""
    for name in file.switches:
        if name in file.jumps:
            findings.add_error(("jumps", name), f"'{name}' is a switch already; rename one", key=True)
        elif name in {*file.states, *file.parameters, *file.definitions}:
            findings.add_error(("switches", name), f"'{name}' stands for something else already; rename one", key=True)

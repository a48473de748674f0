"""Monitor functions: numbers recorded at every point, written as expressions over built-ins (design section 3)."""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.model.codegen import ArrayFunction, NumericModel, ParameterFunction
from pddecont.model.expression import ExpressionError, Scope, build, parse
from pddecont.model.system import Model
from pddecont.orbit.admissibility import closest_approach, event_profiles
from pddecont.orbit.extrema import profile
from pddecont.orbit.mesh import Places
from pddecont.orbit.problem import OrbitProblem, read
from pddecont.orbit.stretches import stretches

Array = NDArray[np.float64]
Measure = Callable[[OrbitProblem, Array], float]


@dataclass(frozen=True, eq=False)
class Monitor:
    """A named expression over measures of an orbit and parameters."""

    name: str
    measures: tuple[Measure, ...]
    function: ParameterFunction

    def value(self, problem: OrbitProblem, x: Array) -> float:
        """Return the monitor at the orbit ``x``; NaN where a part of it is not defined."""
        parts = [measure(problem, x) for measure in self.measures]
        return float(self.function.value(np.concatenate([problem.all_parameters(x), parts]))[0])


def parse_monitor(numeric: NumericModel, name: str, text: str | float, others: Mapping[str, Monitor] | None = None) -> Monitor:
    """Return the monitor that ``text`` writes, which may name ``others``; raise :class:`ExpressionError` with an offset into it."""
    model = numeric.model
    measures: list[Measure] = []
    symbols: list[sympy.Symbol] = []

    def measure(function: Measure) -> sympy.Symbol:
        measures.append(function)
        symbols.append(sympy.Symbol(f"measure {len(measures)}", real=True))
        return symbols[-1]

    inner = model.scope("a monitor", delayed=model.delayed_value)

    def along(reduce: Callable[[OrbitProblem, Array, ArrayFunction], float]) -> Callable[[ast.Call, Scope], sympy.Expr]:
        def builtin(node: ast.Call, _: Scope) -> sympy.Expr:
            function = numeric.function([build(_only(node), inner)])
            return measure(lambda problem, x: reduce(problem, x, function))

        return builtin

    def at(node: ast.Call, _: Scope) -> sympy.Expr:
        if len(node.args) != 2:
            raise ExpressionError("at takes a segment and an expression: at(segment, expression)", node.col_offset)
        segment = _name(model, node.args[0], model.segments, "segment")
        function = numeric.function([build(node.args[1], inner)])
        return measure(lambda problem, x: _at(problem, x, segment, function))

    def time_in(node: ast.Call, _: Scope) -> sympy.Expr:
        mode = _name(model, _only(node), model.modes, "mode")
        return measure(lambda problem, x: _time_in(problem, x, mode))

    def extremum(node: ast.Call, _: Scope) -> sympy.Expr:
        event = _name(model, _only(node), [e.name for e in model.events.values() if e.function is not None], "event")
        return measure(lambda problem, x: _extremum(problem, x, event))

    builtins = {"min": along(_min), "max": along(_max), "mean": along(_mean), "amplitude": along(_amplitude),
                "at": at, "time_in": time_in, "extremum": extremum}  # fmt: skip
    period = measure(lambda problem, x: problem.period(x))
    named = {key: measure(other.value) for key, other in (others or {}).items()}
    scope = Scope({**model.parameter_values, **named, "period": period}, states=model.states, time=False, builtins=builtins,
                  place="a monitor", missing=model.missing,
                  no_delay_because="a state varies along the orbit: write max(...), mean(...) or at(segment, ...)")  # fmt: skip
    try:
        expr = parse(text, scope)
    except ExpressionError as exc:
        bare = next((s for s in model.states if str(exc).startswith(f"'{s}' is not defined")), None)
        if bare:
            raise ExpressionError(f"state '{bare}' varies along the orbit: write max({bare}), mean({bare}), or "
                                  f"at(segment, {bare})", exc.offset) from exc  # fmt: skip
        raise
    function = ArrayFunction((expr,), (), (), (*model.parameter_symbols, *symbols))
    used = expr.free_symbols
    kept = tuple(m if s in used else _nothing for m, s in zip(measures, symbols, strict=True))
    return Monitor(name, kept, ParameterFunction(function))


def _nothing(problem: OrbitProblem, x: Array) -> float:
    return 0.0


def _only(node: ast.Call) -> ast.expr:
    if len(node.args) != 1:
        raise ExpressionError(f"{ast.unparse(node.func)} takes one argument, found {len(node.args)}", node.col_offset)
    return node.args[0]


def _name(model: Model, node: ast.expr, known: Collection[str], what: str) -> str:
    name = ast.unparse(node)
    if name not in known:
        article = "an" if what == "event" else "a"
        raise ExpressionError(f"'{name}' is not {article} {what}{model.hint(f'{what}s', name, known)} ({what}s: "
                              f"{', '.join(known) or 'none'})", node.col_offset)  # fmt: skip
    return name


def _levels(problem: OrbitProblem, x: Array, function: ArrayFunction) -> Array:
    """Return the values at which an expression along the orbit can be largest or smallest."""
    curve = profile(problem, x, function)
    return np.array([*curve.values[:, 0], *curve.values[:, -1], *(e.value for e in curve.extrema)])


def _max(problem: OrbitProblem, x: Array, function: ArrayFunction) -> float:
    return float(np.max(_levels(problem, x, function)))


def _min(problem: OrbitProblem, x: Array, function: ArrayFunction) -> float:
    return float(np.min(_levels(problem, x, function)))


def _amplitude(problem: OrbitProblem, x: Array, function: ArrayFunction) -> float:
    return 0.5 * float(np.ptp(_levels(problem, x, function)))


def _mean(problem: OrbitProblem, x: Array, function: ArrayFunction) -> float:
    mesh = problem.mesh
    parts = stretches(problem, x, np.arange(mesh.n_intervals), delays=function.uses_delayed)
    reads = read(problem, x, parts.places(mesh, mesh.basis.nodes), delays=function.uses_delayed)
    values = function.value(reads.t, reads.x, reads.xd, reads.p)[0].reshape(len(parts.interval), -1)
    h = parts.share() * reads.h[parts.interval]
    return float(np.sum(h[:, None] * mesh.basis.weights * values) / np.sum(h))


def _time_in(problem: OrbitProblem, x: Array, mode: str) -> float:
    durations = x[problem.layout.durations]
    return float(sum(T for T, segment in zip(durations, problem.segments, strict=True) if segment.mode == mode))


def _at(problem: OrbitProblem, x: Array, segment: str, function: ArrayFunction) -> float:
    names = [s.name for s in problem.segments]
    if segment not in names:
        return float("nan")
    interval = problem.mesh.last_interval[[names.index(segment)]]
    reads = read(problem, x, Places(interval, np.ones(1)), delays=function.uses_delayed)
    return float(function.value(reads.t, reads.x, reads.xd, reads.p)[0, 0])


def _extremum(problem: OrbitProblem, x: Array, event: str) -> float:
    """Return the event function where it comes nearest to grazing."""
    found = closest_approach(problem, event_profiles(problem, x), event)
    return float("nan") if found is None else found[1].value

"""A run file with its model: everything resolved and checked before anything is computed."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pddecont.delay.chain import Chain
from pddecont.delay.chebyshev import Chebyshev
from pddecont.delay.direct import Direct
from pddecont.delay.operator import DelayMethod
from pddecont.errors import ModelError, PddecontError, Problem, RunError, SignatureError, suggest
from pddecont.model.codegen import NumericModel
from pddecont.model.document import Document, KeyPath, parse_document, read_text
from pddecont.model.effects import LeftOut, without
from pddecont.model.expression import ExpressionError, parse
from pddecont.model.system import Model, check_signature, parse_model
from pddecont.model.validation import validate
from pddecont.orbit.meshing import MeshRule
from pddecont.shipped.find import find
from pddecont.steps.schema import Basin, Delay, Initial, Integration, Mesh, RunBlock, RunFile, Step, Sweep

Array = NDArray[np.float64]
COLUMNS = {"index", "label", "kind", "period", "stable", "admissible", "error_estimate", "n_unknowns", "n_unstable", "note"}


@dataclass(frozen=True)
class Overrides:
    """What the command line changes of a run file: parameter values (as text) and effects left out."""

    set: tuple[tuple[str, str], ...] = ()
    without: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Plan:
    """A checked run; ``parameters`` are the run's values, ``base`` the folder that its paths are relative to."""

    run: RunBlock
    model: Model
    numeric: NumericModel
    left_out: LeftOut
    parameters: Array
    monitors: Mapping[str, str | float]
    warnings: tuple[Problem, ...]
    model_text: str
    run_text: str
    source: str
    base: Path

    def step_parameters(self, step: Step, start: Array | None = None) -> Array:
        """Return the parameter values of ``step``: those of the run (or ``start``), then the step's own."""
        p = (self.parameters if start is None else start).copy()
        for name, text in step.set.items():
            p[self.numeric.parameter_index(name)] = self.number(text, p)
        return p

    def number(self, text: str | float, p: Array | None = None) -> float:
        """Return the number that an expression of the run file stands for at parameters ``p``."""
        values = dict(zip(self.model.parameters, self.parameters if p is None else p, strict=True))
        return self.model.evaluate(parse(text, self.model.parameter_scope("a run file")), values)

    @staticmethod
    def plain(text: str) -> str | float:
        """Return the text of a key as a number where it is one."""
        return _plain(text)

    def delay_method(self, step: Step) -> DelayMethod:
        """Return the way the delay is discretised in ``step``."""
        return delay_method(step.delay or self.run.delay)


def delay_method(spec: Delay) -> DelayMethod:
    """Return the delay method that a file asks for."""
    if spec.method == "chain":
        return Chain(spec.order or 2, spec.n or 15)
    if spec.method == "chebyshev":
        return Chebyshev(spec.n or 16)
    return Direct(spec.track_breaking_points is not False)


def mesh_rule(spec: Mesh) -> MeshRule:
    """Return the mesh rule that a file asks for."""
    return MeshRule(spec.degree, spec.intervals, None if spec.intervals is not None else spec.tol or 1e-8)


def load_document(path: str) -> Document:
    """Return the YAML document at ``path`` (``-``: standard input; or the name of a shipped model or run)."""
    if path == "-":
        return parse_document(sys.stdin.read(), "<stdin>", RunError)
    found = find(path)
    return parse_document(read_text(found, RunError), str(found), RunError)


def is_run_file(document: Document) -> bool:
    """Whether the document describes a run (and not a model)."""
    return "states" not in document.data and ("steps" in document.data or "model" in document.data)


def load_plan(document: Document, overrides: Overrides | None = None) -> Plan:
    """Return the checked run that ``document`` describes; raise ModelError or RunError with all that is wrong."""
    overrides = overrides or Overrides()
    folder = Path(document.path).parent
    if is_run_file(document):
        run, problems = validate(document, RunFile)
        if run is None:
            raise RunError(problems)
        try:
            model_path = find(run.model, folder)
            model_document = parse_document(read_text(model_path, ModelError), str(model_path), ModelError)
        except PddecontError as exc:
            if isinstance(exc, ModelError) and any(p.line for p in exc.problems):
                raise
            raise RunError([document.problem(("model",), f"the model {exc}")]) from exc
        model, warnings = parse_model(model_document)
        prefix: KeyPath = ()
    else:
        model, warnings = parse_model(document)
        model_document = document
        prefix = ("run",)
        if document.data.get("run") is None:
            raise RunError([document.problem((), f"model '{model.name}' says nothing of a run; add a 'run' block or write a run file "
                                                 f"with 'model: {document.path}'")])  # fmt: skip
        run, problems = validate(document, RunBlock, prefix)
        if run is None:
            raise RunError(problems)
    return _Planner(document, prefix, run, model, overrides).plan(warnings, model_document.text, folder)


class _Planner:
    """Collects the problems of a run against its model."""

    def __init__(self, document: Document, prefix: KeyPath, run: RunBlock, model: Model, overrides: Overrides):
        self.document, self.prefix, self.run, self.overrides = document, prefix, run, overrides
        self.whole, self.model = model, model
        self.problems: list[Problem] = []

    def complain(self, path: Sequence[str | int], message: str, *, offset: int = 0, key: bool = False) -> None:
        self.problems.append(self.document.problem((*self.prefix, *path), message, offset=offset, key=key))

    def plan(self, warnings: Sequence[Problem], model_text: str, folder: Path) -> Plan:
        left_out = LeftOut()
        off = [*self.run.effects.off, *self.overrides.without]
        try:
            self.model, left_out = without(self.whole, off)
        except PddecontError as exc:
            place = next((i for i, name in enumerate(self.run.effects.off) if name not in self.whole.effects), None)
            if place is None:
                raise RunError.at("--without", 0, 0, str(exc)) from exc
            self.complain(("effects", "off", place), str(exc))
        numeric = NumericModel(self.model)
        parameters = self.parameters(numeric)
        self.check_delays(numeric, parameters)
        self.check_period(numeric, parameters)
        self.check_monitors(numeric)
        for i, step in enumerate(self.run.steps):
            self.check_step(i, step)
        if self.problems:
            raise RunError(self.problems)
        return Plan(self.run, self.model, numeric, left_out, parameters, self.run.monitors, tuple(warnings), model_text,
                    self.document.text, self.document.path, folder)  # fmt: skip

    def formula(self, path: Sequence[str | int], text: str | float, values: Mapping[str, float]) -> float:
        try:
            value = self.model.evaluate(parse(text, self.model.parameter_scope("a run file")), values)
        except ExpressionError as exc:
            self.complain(path, str(exc), offset=exc.offset)
            return 1.0
        except (TypeError, ValueError):
            self.complain(path, "is not a real number at these parameters")
            return 1.0
        return value

    def parameters(self, numeric: NumericModel) -> Array:
        values = dict(self.model.parameters)
        for name, text in self.run.set.items():
            if name not in values:
                self.complain(("set", name), f"'{name}' is not a parameter{suggest(name, values)}", key=True)
            else:
                values[name] = self.formula(("set", name), text, values)
        for name, given in self.overrides.set:
            option = f"--set {name}={given}"
            if name not in values:
                raise RunError.at(option, 0, 0, f"'{name}' is not a parameter{suggest(name, values)} "
                                                f"(parameters: {', '.join(values)})")  # fmt: skip
            try:
                values[name] = self.model.evaluate(parse(_plain(given), self.model.parameter_scope("--set")), values)
            except (ExpressionError, TypeError, ValueError) as exc:
                raise RunError.at(option, 0, 0, str(exc)) from exc
        return np.array(list(values.values()), dtype=float)

    def check_delays(self, numeric: NumericModel, parameters: Array) -> None:
        for delay, value in zip(self.model.delays, numeric.delays.value(parameters), strict=True):
            if not value >= 0:
                self.complain(("set",), f"the delay {delay} is {value:g} with these parameters; a delay is positive or zero")

    def check_period(self, numeric: NumericModel, parameters: Array) -> None:
        if not self.model.forced:
            return
        with np.errstate(all="ignore"):
            period = float(numeric.period.value(parameters)[0])
        if not 0 < period < np.inf:
            self.complain(("set",), f"the forcing period is {period:g} with these parameters; expected a positive number")

    def check_monitors(self, numeric: NumericModel) -> None:
        from pddecont.orbit.monitors import parse_monitor

        for name, text in self.run.monitors.items():
            if name in COLUMNS or name in self.whole.parameters:
                what = "a parameter" if name in self.whole.parameters else "a column of every table"
                self.complain(("monitors", name), f"'{name}' is {what} already; give the monitor another name", key=True)
            try:
                parse_monitor(numeric, name, text)
            except ExpressionError as exc:
                self.complain(("monitors", name), str(exc), offset=exc.offset)

    def check_step(self, i: int, step: Step) -> None:
        path: tuple[str | int, ...] = ("steps", i)
        values = dict(self.model.parameters)
        earlier = {s.name: s for s in self.run.steps[:i]}
        if step.name in earlier:
            self.complain((*path, "name"), f"step '{step.name}' stands already above; names of steps differ")
        for name, text in step.set.items():
            if name not in values:
                self.complain((*path, "set", name), f"'{name}' is not a parameter{suggest(name, values)}", key=True)
            else:
                self.formula((*path, "set", name), text, values)
        self.check_source((*path, step.kind, "from"), step, earlier)
        if step.simulate:
            self.check_simulate((*path, "simulate"), step, values)
        if step.sweep:
            self.check_sweep((*path, "sweep"), step, values)
        if step.basin:
            self.check_basin((*path, "basin"), step, values)
        if step.orbit and step.orbit.signature is not None:
            self.check_signature((*path, "orbit", "signature"), step.orbit.signature)
        if step.continue_:
            self.check_continue((*path, "continue"), step, values)

    def check_signature(self, path: tuple[str | int, ...], signature: list[str]) -> None:
        try:
            check_signature(self.model, signature)
        except SignatureError as exc:
            self.complain(path, str(exc))

    def check_users(self, path: tuple[str | int, ...], functions: Mapping[str, str | float]) -> None:
        from pddecont.orbit.monitors import parse_monitor

        if not functions:
            return
        numeric = NumericModel(self.model)
        monitors = {}
        for name, text in self.run.monitors.items():
            with contextlib.suppress(ExpressionError):  # a wrong monitor has its own complaint
                monitors[name] = parse_monitor(numeric, name, text)
        for name, text in functions.items():
            if name in monitors or name in COLUMNS or name in self.whole.parameters:
                what = "a monitor" if name in monitors else "a parameter" if name in self.whole.parameters else "a column of every table"
                self.complain((*path, name), f"'{name}' is {what} already; give the user function another name", key=True)
            try:
                parse_monitor(numeric, name, text, monitors)
            except ExpressionError as exc:
                self.complain((*path, name), str(exc), offset=exc.offset)

    def check_source(self, path: tuple[str | int, ...], step: Step, earlier: Mapping[str, Step]) -> None:
        source = step.source
        if source is None or source.file is not None:
            return
        if source.step not in earlier:
            self.complain(path, f"step '{source.step}' does not stand above this one{suggest(source.step, earlier)} "
                                f"(steps above: {', '.join(earlier) or 'none'})")  # fmt: skip
            return
        kind = earlier[source.step].kind
        if kind in ("sweep", "basin") and source.point is None and source.index is None:
            self.complain(path, f"'{source.step}' holds many attractors; say which: {{step: {source.step}, point: A1}}")
        if step.kind == "continue" and kind in ("sweep", "basin"):
            self.complain(path, f"'{source.step}' holds attractors; put an orbit step between: "
                                f"{{name: orbit, orbit: {{from: {{step: {source.step}, point: A1}}}}}}")  # fmt: skip
        if step.kind == "continue" and kind == "simulate":
            self.complain(path, f"'{source.step}' is a trajectory; put an orbit step between: "
                                f"{{name: orbit, orbit: {{from: {source.step}}}}}")  # fmt: skip
        if kind == "continue" and source.point is None and source.index is None:
            self.complain(path, f"'{source.step}' holds many orbits; say which: {{step: {source.step}, point: GR1}} or 'index: 0'")

    def check_simulate(self, path: tuple[str | int, ...], step: Step, values: Mapping[str, float]) -> None:
        assert step.simulate is not None
        body = step.simulate
        t_end = self.positive_time((*path, "t_end"), body.t_end, values)
        self.check_initial((*path, "initial"), body.initial, values)
        self.check_integration(path, step, body)
        for text, changes in body.at.items():
            here = (*path, "at", text)
            time = self.formula(here, _plain(text), values)
            if not 0 < time < t_end:
                self.complain(here, f"the time {time:g} does not lie between 0 and t_end, {t_end:g}", key=True)
            for name, value in changes.items():
                if name not in values:
                    self.complain((*here, name), f"'{name}' is not a parameter{suggest(name, values)}", key=True)
                else:
                    self.formula((*here, name), value, values)
        since = self.formula((*path, "record", "from"), body.record.from_, values)
        if not 0 <= since < t_end:
            self.complain((*path, "record", "from"), f"the time {since:g} does not lie between 0 and t_end, {t_end:g}")
        scope = self.model.scope("a signal", delayed=self.model.delayed_value)
        for name, formula in body.record.signals.items():
            here = (*path, "record", "signals", name)
            if name in self.model.states:
                self.complain(here, f"'{name}' is a state already; give the signal another name", key=True)
            try:
                expr = parse(formula, scope)
            except ExpressionError as exc:
                self.complain(here, str(exc), offset=exc.offset)
                continue
            if (step.delay or self.run.delay).method == "chain" and expr.free_symbols & set(self.model.delayed_symbols):
                self.complain(here, "a chain has no delayed values of its own to record; give this step 'delay: {method: direct}'")
        if body.record.every is not None:
            self.positive_time((*path, "record", "every"), body.record.every, values)

    def positive_time(self, path: tuple[str | int, ...], text: str | float, values: Mapping[str, float]) -> float:
        time = self.formula(path, text, values)
        if time <= 0:
            self.complain(path, f"{path[-1]} is {time:g}; expected a positive time")
        return time

    def check_initial(self, path: tuple[str | int, ...], initial: Initial, values: Mapping[str, float]) -> None:
        if initial.mode is not None and initial.mode not in self.model.modes:
            self.complain((*path, "mode"), f"mode '{initial.mode}' is not defined (modes: {', '.join(self.model.modes)})")
        for name, text in initial.states.items():
            if name not in self.model.states:
                self.complain((*path, name), f"'{name}' is not a state{suggest(name, self.model.states)}", key=True)
            else:
                self.formula((*path, name), text, values)
        if not isinstance(initial.history, Mapping):
            return
        for name, text in initial.history.items():
            here = (*path, "history", name)
            if name not in self.model.states:
                self.complain(here, f"'{name}' is not a state{suggest(name, self.model.states)}", key=True)
            try:
                parse(text, self.model.history_scope())
            except ExpressionError as exc:
                self.complain(here, str(exc), offset=exc.offset)

    def check_integration(self, path: tuple[str | int, ...], step: Step, body: Integration) -> None:
        for event, mode in body.stick.items():
            if event not in self.model.events:
                self.complain((*path, "stick", event), f"'{event}' is not an event{suggest(event, self.model.events)}", key=True)
            if mode not in self.model.modes:
                self.complain((*path, "stick", event), f"mode '{mode}' is not defined{suggest(mode, self.model.modes)} "
                                                       f"(modes: {', '.join(self.model.modes)})")  # fmt: skip
        if body.max_step is not None:
            self.positive_time((*path, "max_step"), body.max_step, self.model.parameters)
        delay = step.delay or self.run.delay
        if delay.method == "chebyshev":
            self.complain(path, "trajectories are computed with the delay itself or the chain, not with a Chebyshev delay line; give this "
                                "step 'delay: {method: direct}'", key=True)  # fmt: skip

    def check_settling(self, path: tuple[str | int, ...], step: Step, body: Sweep | Basin, values: Mapping[str, float]) -> None:
        self.check_integration(path, step, body)
        self.positive_time((*path, "transient"), body.transient, values)
        if body.lyapunov and body.stick:
            self.complain((*path, "lyapunov"), "what neighbouring motions do where events accumulate is not followed: Lyapunov exponents "
                                               "do not go with 'stick'")  # fmt: skip
        if body.lyapunov and body.method == "stiff":
            self.complain((*path, "lyapunov"), "Lyapunov exponents go with the explicit method; leave 'method: stiff' out")
        section = body.section
        if (section is None or section.phase is not None) and not self.model.forced:
            events = next(iter(self.model.events), None)
            example = f"{{event: {events}}}" if events else f"{{zero: {self.model.states[0]} - 1}}"
            self.complain((*path, "section") if section else path, "the model has no forcing whose periods could count returns; say where "
                          f"they are counted: 'section: {example}'", key=section is None)  # fmt: skip
        if section is not None and section.event is not None and section.event not in self.model.events:
            self.complain((*path, "section", "event"), f"'{section.event}' is not an event{suggest(section.event, self.model.events)} "
                                                       f"(events: {', '.join(self.model.events) or 'none'})")  # fmt: skip
        if section is not None and section.zero is not None:
            try:
                parse(section.zero, self.model.scope("a section"))
            except ExpressionError as exc:
                self.complain((*path, "section", "zero"), str(exc), offset=exc.offset)
        for name, (low, high, n) in body.over.items():
            here = (*path, "over", name)
            ends = [self.formula((*here, k), text, values) for k, text in enumerate((low, high))]
            if ends[0] > ends[1] or (ends[0] == ends[1] and n != 1):
                self.complain(here, f"the range is empty: {ends[0]:g} is not below {ends[1]:g}")

    def check_sweep(self, path: tuple[str | int, ...], step: Step, values: Mapping[str, float]) -> None:
        body = step.sweep
        assert body is not None
        self.check_settling(path, step, body, values)
        for name in body.over:
            if name not in values:
                self.complain((*path, "over", name), f"'{name}' is not a parameter{suggest(name, values)} "
                                                     f"(parameters: {', '.join(values)})", key=True)  # fmt: skip
        for i, initial in enumerate(body.initial):
            self.check_initial((*path, "initial", i), initial, values)
            if isinstance(initial.history, Mapping) and i and initial.history != body.initial[0].history:
                self.complain((*path, "initial", i), "all initial states of a sweep share one history; give other histories a step of "
                                                     "their own")  # fmt: skip
        for name, limits in body.random.box.items() if body.random else ():
            here = (*path, "random", "box", name)
            if name not in self.model.states:
                self.complain(here, f"'{name}' is not a state{suggest(name, self.model.states)}", key=True)
            for k, text in enumerate(limits):
                self.formula((*here, k), text, values)

    def check_basin(self, path: tuple[str | int, ...], step: Step, values: Mapping[str, float]) -> None:
        body = step.basin
        assert body is not None
        self.check_settling(path, step, body, values)
        self.check_initial((*path, "initial"), body.initial, values)
        for name in body.over:
            if name not in self.model.states:
                self.complain((*path, "over", name), f"'{name}' is not a state{suggest(name, self.model.states)} "
                                                     f"(states: {', '.join(self.model.states)})", key=True)  # fmt: skip
            elif name in body.initial.states:
                self.complain((*path, "initial", name), f"'{name}' varies over the grid and cannot be given too", key=True)

    def check_continue(self, path: tuple[str | int, ...], step: Step, values: Mapping[str, float]) -> None:
        body = step.continue_
        assert body is not None
        if len(set(body.free)) < len(body.free):
            self.complain((*path, "free"), f"the parameter '{body.free[0]}' stands twice; two different ones follow a special point")
        if body.branch == "switch" and len(body.free) == 2:
            self.complain((*path, "branch"), "'switch' leads onto another branch in one free parameter; found two")
        if body.signature is not None:
            self.check_signature((*path, "signature"), body.signature)
        self.check_users((*path, "events_along"), body.events_along)
        for k, name in enumerate(body.free):
            if name not in values:
                self.complain((*path, "free", k), f"'{name}' is not a parameter{suggest(name, values)}")
            elif name not in body.range:
                self.complain((*path, "range"), f"the free parameter '{name}' has no range; add '{name}: [lowest, highest]'")
        for name, limits in body.range.items():
            if name not in body.free:
                self.complain((*path, "range", name), f"'{name}' has a range but is not free (free: {', '.join(body.free)})", key=True)
                continue
            low, high = (self.formula((*path, "range", name, k), text, values) for k, text in enumerate(limits))
            if not low < high:
                self.complain((*path, "range", name), f"the range is empty: {low:g} is not below {high:g}")


def _plain(text: str) -> str | float:
    """Return text from the command line as a number where it is one."""
    try:
        return float(text)
    except ValueError:
        return text



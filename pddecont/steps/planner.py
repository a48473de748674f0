"""The problems of a run against its model, all of them, each at its place in the file."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import PddecontError, Problem, RunError, SignatureError, suggest
from pddecont.model.codegen import NumericModel
from pddecont.model.document import Document, KeyPath
from pddecont.model.effects import without
from pddecont.model.expression import ExpressionError, parse
from pddecont.model.system import Model, check_signature
from pddecont.steps.comparisons import check_precision
from pddecont.steps.lengths import wrong_lengths
from pddecont.steps.motions import check_basin, check_simulate, check_sweep
from pddecont.steps.named import named_in
from pddecont.steps.plan import Plan, as_number
from pddecont.steps.schema import Delay, Mesh, OnBranch, OnCurve, RunBlock, Step

Array = NDArray[np.float64]
NEED_MULTIPLIERS = {"BP", "TR", "FF", "FT", "PT", "TT", "GL", "GP", "GT"}
COLUMNS = {"index", "label", "kind", "period", "stable", "admissible", "error_estimate", "n_unknowns", "n_unstable", "note"}


@dataclass(frozen=True)
class Overrides:
    """What the command line changes of a run file: parameter values (as text), effects left out, the accuracy asked for."""

    set: tuple[tuple[str, str], ...] = ()
    without: tuple[str, ...] = ()
    accuracy: float | None = None


class Planner:
    """Collects the problems of a run against its model."""

    def __init__(self, document: Document, prefix: KeyPath, run: RunBlock, model: Model, overrides: Overrides):
        if overrides.accuracy is not None:
            open_ = {"accuracy": overrides.accuracy, "delay": Delay.model_validate({}), "mesh": Mesh.model_validate({})}
            run = run.model_copy(update=open_)
        self.document, self.prefix, self.run, self.overrides = document, prefix, run, overrides
        self.whole, self.model = model, model
        self.problems: list[Problem] = []
        self.warnings: list[Problem] = []

    def complain(self, path: Sequence[str | int], message: str, *, offset: int = 0, key: bool = False) -> None:
        """Note a problem at a place in the run."""
        self.problems.append(self.document.problem((*self.prefix, *path), message, offset=offset, key=key))

    def warn(self, path: Sequence[str | int], message: str) -> None:
        """Note a warning at a place in the run."""
        self.warnings.append(self.document.problem((*self.prefix, *path), message, key=True))

    def plan(self, warnings: Sequence[Problem], model_text: str, folder: Path) -> Plan:
        """Return the plan of the run, or raise RunError with all problems."""
        off = [*self.run.effects.off, *self.overrides.without]
        try:
            self.model = without(self.whole, off, named_in(self.run))
        except PddecontError as exc:
            place = next((i for i, name in enumerate(self.run.effects.off) if name not in self.whole.effects), None)
            if place is None and self.overrides.without:
                raise RunError.at("--without", 0, 0, str(exc)) from exc
            self.complain(("effects", "off", *([] if place is None else [place])), str(exc))
        numeric = NumericModel(self.model)
        parameters = self.parameters(numeric)
        values = dict(zip(self.model.parameters, parameters.tolist(), strict=True))
        self.check_lengths(values)
        self.check_monitors(numeric)
        for i, step in enumerate(self.run.steps):
            self.check_step(i, step, values)
        if self.problems:
            raise RunError(self.problems)
        return Plan(self.run, self.model, numeric, parameters, self.run.monitors, (*warnings, *self.warnings), model_text,
                    self.document.text, self.document.path, folder)  # fmt: skip

    def formula(self, path: Sequence[str | int], text: str | float, values: Mapping[str, float]) -> float:
        """Return the number that a formula stands for; note a problem where it stands for none."""
        try:
            value = self.model.evaluate(parse(text, self.model.parameter_scope("a run file")), values)
        except ExpressionError as exc:
            self.complain(path, str(exc), offset=exc.offset)
            return 1.0
        return value

    def parameters(self, numeric: NumericModel) -> Array:
        """Return the run's parameter values: the model's, then the file's, then the command line's."""
        values = dict(self.model.parameters)
        for name, text in self.run.set.items():
            if self.check_settable(("set", name), name, values):
                values[name] = self.formula(("set", name), text, values)
        for name, given in self.overrides.set:
            option = f"--set {name}={given}"
            if name not in values:
                raise RunError.at(option, 0, 0, f"'{name}' is not a parameter{suggest(name, values)} "
                                                f"(parameters: {', '.join(values)})")  # fmt: skip
            if name in self.model.fixed:
                raise RunError.at(option, 0, 0, self.fixed(name))
            try:
                values[name] = self.model.evaluate(parse(as_number(given), self.model.parameter_scope("--set")), values)
            except ExpressionError as exc:
                raise RunError.at(option, 0, 0, str(exc)) from exc
        return numeric.with_fixed(np.array(list(values.values()), dtype=float))

    def fixed(self, name: str) -> str:
        """Return why a parameter cannot be given."""
        return f"'{name}' is {self.model.left_out.reasons['parameters'][name]}; keep the effect, or leave '{name}' as it is"

    def check_settable(self, path: Sequence[str | int], name: str, values: Mapping[str, float], *, key: bool = True) -> bool:
        """Check that a name is a parameter that no effect left out has set; return whether it is."""
        if name not in values:
            self.complain(path, f"'{name}' is not a parameter{suggest(name, values)} (parameters: {', '.join(values)})", key=key)
        elif name in self.model.fixed:
            self.complain(path, self.fixed(name), key=key)
        return name in values and name not in self.model.fixed

    def check_lengths(self, values: Mapping[str, float]) -> None:
        """Check that delays and the forcing period are lengths of time, with what the file and the command line set."""
        for message, names in wrong_lengths(self.model, values):
            option = next((f"--set {name}={given}" for name, given in self.overrides.set if name in names), None)
            if option is not None:
                raise RunError.at(option, 0, 0, message)
            at = next((name for name in self.run.set if name in names), None)
            self.complain(("set", *([] if at is None else [at])), message)

    def check_step_lengths(self, path: tuple[str | int, ...], step: Step, values: Mapping[str, float]) -> None:
        """Check the same of a step, as far as it does not depend on parameters that the step takes from where it starts."""
        for message, names in wrong_lengths(self.model, values):
            own = [name for name in step.set if name in names]
            if own and (step.source is None or names <= set(own)):
                self.complain((*path, own[0]), message)

    def check_monitors(self, numeric: NumericModel) -> None:
        """Check that monitors can be read and have names of their own."""
        from pddecont.orbit.monitors import parse_monitor

        for name, text in self.run.monitors.items():
            if name in COLUMNS or name in self.whole.parameters:
                what = "a parameter" if name in self.whole.parameters else "a column of every table"
                self.complain(("monitors", name), f"'{name}' is {what} already; give the monitor another name", key=True)
            try:
                parse_monitor(numeric, name, text)
            except ExpressionError as exc:
                self.complain(("monitors", name), str(exc), offset=exc.offset)

    def check_step(self, i: int, step: Step, run_values: Mapping[str, float]) -> None:
        """Check a step, by its kind."""
        path: tuple[str | int, ...] = ("steps", i)
        values = dict(run_values)
        earlier = {s.name: s for s in self.run.steps[:i]}
        if step.name in earlier:
            self.complain((*path, "name"), f"step '{step.name}' stands already above; names of steps differ")
        for name, text in step.set.items():
            if self.check_settable((*path, "set", name), name, values):
                values[name] = self.formula((*path, "set", name), text, values)
        self.check_step_lengths((*path, "set"), step, values)
        self.check_source((*path, step.kind, "from"), step, earlier)
        if step.simulate:
            check_simulate(self, (*path, "simulate"), step, values)
        if step.sweep:
            check_sweep(self, (*path, "sweep"), step, values)
        if step.basin:
            check_basin(self, (*path, "basin"), step, values)
        if step.precision:
            check_precision(self, (*path, "precision"), step, values, earlier)
        if step.orbit and step.orbit.signature is not None:
            self.check_signature((*path, "orbit", "signature"), step.orbit.signature)
        if step.continue_:
            self.check_continue((*path, "continue"), step, values)

    def check_signature(self, path: tuple[str | int, ...], signature: list[str]) -> None:
        """Check that a motion can run through a signature."""
        try:
            check_signature(self.model, signature)
        except SignatureError as exc:
            self.complain(path, str(exc))

    def check_users(self, path: tuple[str | int, ...], functions: Mapping[str, str | float]) -> None:
        """Check user functions."""
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

    def check_detect(self, path: tuple[str | int, ...], step: Step) -> None:
        """Check that the kinds of special points asked for can be found in this step."""
        body = step.continue_
        assert body is not None
        known, where = (OnBranch, "one free parameter") if len(body.free) == 1 else (OnCurve, "two free parameters")
        for k, kind in enumerate(body.detect or ()):
            if kind not in get_args(known):
                self.complain((*path, k), f"'{kind}' is not found with {where} (there are: {', '.join(get_args(known))})")
            elif kind in NEED_MULTIPLIERS and not body.stability:
                self.complain((*path, k), f"'{kind}' is seen from multipliers; add 'stability: true' to this step")

    def check_source(self, path: tuple[str | int, ...], step: Step, earlier: Mapping[str, Step]) -> None:
        """Check where a step starts."""
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
        if kind == "precision":
            self.complain(path, f"'{source.step}' compares settings; start from the step that it compares them on")
        if kind == "continue" and source.point is None and source.index is None:
            self.complain(path, f"'{source.step}' holds many orbits; say which: {{step: {source.step}, point: GR1}} or 'index: 0'")

    def check_continue(self, path: tuple[str | int, ...], step: Step, values: Mapping[str, float]) -> None:
        """Check a continue step."""
        body = step.continue_
        assert body is not None
        if len(set(body.free)) < len(body.free):
            self.complain((*path, "free"), f"the parameter '{body.free[0]}' stands twice; two different ones follow a special point")
        if body.branch == "switch" and len(body.free) == 2:
            self.complain((*path, "branch"), "'switch' leads onto another branch in one free parameter; found two")
        if body.signature is not None:
            self.check_signature((*path, "signature"), body.signature)
        self.check_users((*path, "events_along"), body.events_along)
        self.check_detect((*path, "detect"), step)
        for k, name in enumerate(body.free):
            if self.check_settable((*path, "free", k), name, values, key=False) and name not in body.range:
                self.complain((*path, "range"), f"the free parameter '{name}' has no range; add '{name}: [lowest, highest]'")
        for name, limits in body.range.items():
            if name not in body.free:
                self.complain((*path, "range", name), f"'{name}' has a range but is not free (free: {', '.join(body.free)})", key=True)
                continue
            low, high = (self.formula((*path, "range", name, k), text, values) for k, text in enumerate(limits))
            if not low < high:
                self.complain((*path, "range", name), f"the range is empty: {low:g} is not below {high:g}")

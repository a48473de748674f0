"""From what a run file says to a plan, with all that is wrong with it."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from pddecont.codegen import NumericModel
from pddecont.errors import PddecontError, Problem, RunError, suggest
from pddecont.model import (
    Document,
    ExpressionError,
    KeyPath,
    Model,
    ReferencedNames,
    add_rests,
    explain_direct_only,
    leave_out_effects,
    parse_expression,
)
from pddecont.orbit import Monitor, parse_monitor
from pddecont.runfile.checker import Checker, Path, explain_fixed
from pddecont.runfile.durations import find_wrong_durations
from pddecont.runfile.fields import Delay, Mesh
from pddecont.runfile.formula import ParameterFormula, as_number
from pddecont.runfile.holding import Holding
from pddecont.runfile.kinds import StepKind
from pddecont.runfile.plan import Plan, PlannedStep
from pddecont.runfile.schema import RunBlock, StepBlock
from pddecont.runfile.step_input import StepInput

WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
# Names of columns of every table of orbits, which monitors and user functions cannot have.
COLUMNS = {
    "index",
    "label",
    "kind",
    "period",
    "stable",
    "admissible",
    "error_estimate",
    "n_unknowns",
    "n_unstable",
    "note",
}
SHARED = {"accuracy", "delay", "mesh", "monitors"}


@dataclass(frozen=True)
class Overrides:
    """What the command line changes of a run file: parameters (as text), effects left out, the accuracy asked for."""

    set: tuple[tuple[str, str], ...] = ()
    without: tuple[str, ...] = ()
    accuracy: float | None = None


@dataclass(frozen=True, eq=False)
class RunDocument:
    """A run as it is written: its document, the place of its keys in that, and the model's text and path."""

    document: Document
    prefix: KeyPath
    run: RunBlock[StepBlock]
    model: Model
    model_text: str
    model_path: str
    folder: FilePath


def make_plan(
    text: RunDocument, kinds: Mapping[str, StepKind], overrides: Overrides, warnings: Sequence[Problem] = ()
) -> Plan:
    """Return the plan of a run; raise RunError with all that is wrong with it."""
    run, document = text.run, text.document
    if overrides.accuracy is not None:
        unset = {"delay": Delay.model_validate({}), "mesh": Mesh.model_validate({})}
        run = run.model_copy(update={"accuracy": overrides.accuracy, **unset})

    def make_problem(path: Path, message: str, *, offset: int = 0, key: bool = False) -> Problem:
        return document.problem((*text.prefix, *path), message, offset=offset, key=key)

    checker = Checker(text.model, make_problem, document.path)
    checker.model = _leave_out(checker, run, kinds, overrides)
    sticks = (pair for step in run.steps for pair in kinds[step.kind].list_sticks(step.body))
    checker.model = add_rests(checker.model, sticks)
    numeric = NumericModel(checker.model)
    values = _resolve_parameters(checker, run, overrides)
    parameters = numeric.with_fixed(np.array(list(values.values()), dtype=float))
    values = dict(zip(checker.model.parameters, parameters.tolist(), strict=True))
    _check_durations(checker, run, overrides, values)
    check_new_names(checker, ("monitors",), run.monitors, "monitor")
    monitors = resolve_monitors(checker, ("monitors",), run.monitors, numeric)
    planner = StepPlanner(checker, run, kinds, numeric, values, monitors, text.folder)
    steps = [planner.plan_step(i) for i in range(len(run.steps))]
    if checker.errors:
        raise RunError(checker.errors)
    return Plan(
        checker.model,
        numeric,
        parameters,
        run.accuracy,
        monitors,
        tuple(steps),
        run.model_dump(mode="json", by_alias=True, include=SHARED),
        (*warnings, *checker.warnings),
        text.model_text,
        document.text,
        document.path,
        text.folder,
        {"model file": text.model_path, "run file": document.path, **planner.inputs},
    )


def _leave_out(
    checker: Checker, run: RunBlock[StepBlock], kinds: Mapping[str, StepKind], overrides: Overrides
) -> Model:
    """Return the model without the effects that the file or the command line leaves out."""
    whole = checker.model
    try:
        return leave_out_effects(whole, [*run.effects.off, *overrides.without], find_referenced_names(run, kinds))
    except PddecontError as exc:
        place = next((i for i, name in enumerate(run.effects.off) if name not in whole.effects), None)
        if place is None and overrides.without:
            raise RunError.at("--without", 0, 0, str(exc)) from exc
        checker.add_error(("effects", "off", *([] if place is None else [place])), str(exc))
        return whole


def find_referenced_names(run: RunBlock[StepBlock], kinds: Mapping[str, StepKind]) -> ReferencedNames:
    """Return the names in a run's expressions, grids and boxes, and the modes that its motions are put into.

    Initial values and histories need no state: they say where it begins if it is there.
    """
    texts = [*run.monitors.values(), *(text for s in run.steps for text in kinds[s.kind].list_names(s.body))]
    modes = frozenset(mode for step in run.steps for mode in kinds[step.kind].list_modes(step.body))
    return ReferencedNames(frozenset(word for text in texts for word in WORD.findall(str(text))), modes)


def _resolve_parameters(checker: Checker, run: RunBlock[StepBlock], overrides: Overrides) -> dict[str, float]:
    """Return the run's parameter values: the model's, then the file's, then the command line's."""
    model = checker.model
    values = dict(model.parameters)
    for name, text in run.set.items():
        if checker.check_settable(("set", name), name):
            values[name] = checker.evaluate(("set", name), text, values)
    for name, given in overrides.set:
        option = f"--set {name}={given}"
        if name not in values:
            known = f"{suggest(name, values)} (parameters: {', '.join(values)})"
            raise RunError.at(option, 0, 0, f"'{name}' is not a parameter{known}")
        if name in model.fixed:
            raise RunError.at(option, 0, 0, explain_fixed(model, name))
        try:
            expr = parse_expression(as_number(given), model.parameter_scope("--set"))
            values[name] = model.evaluate(expr, values)
        except ExpressionError as exc:
            raise RunError.at(option, 0, 0, str(exc)) from exc
    return values


def _check_durations(
    checker: Checker, run: RunBlock[StepBlock], overrides: Overrides, values: Mapping[str, float]
) -> None:
    """Check that delays and the forcing period are lengths of time, with what the file and the command line set."""
    for message, names in find_wrong_durations(checker.model, values):
        option = next((f"--set {name}={given}" for name, given in overrides.set if name in names), None)
        if option is not None:
            raise RunError.at(option, 0, 0, message)
        at = next((name for name in run.set if name in names), None)
        checker.add_error(("set", *([] if at is None else [at])), message)


def resolve_monitors(
    checker: Checker,
    path: Path,
    texts: Mapping[str, str | float],
    numeric: NumericModel,
    others: Mapping[str, Monitor] | None = None,
) -> dict[str, Monitor]:
    """Return monitors by name, which may name ``others``; note texts that write none."""
    found: dict[str, Monitor] = {}
    for name, text in texts.items():
        try:
            found[name] = parse_monitor(numeric, name, text, others)
        except ExpressionError as exc:
            checker.add_error((*path, name), str(exc), offset=exc.offset)
    return found


def check_new_names(
    checker: Checker, path: Path, texts: Mapping[str, str | float], called: str, monitors: Collection[str] = ()
) -> None:
    """Check that what is recorded at every point has names of its own; ``called`` is what it is in words."""
    for name in texts:
        taken = (
            "a monitor"
            if name in monitors
            else "a parameter"
            if name in checker.model.parameters
            else "a column of every table"
            if name in COLUMNS
            else ""
        )
        if taken:
            checker.add_error((*path, name), f"'{name}' is {taken} already; give the {called} another name", key=True)


@dataclass(frozen=True, eq=False)
class StepPlanner:
    """Resolves the steps of a run, one after another."""

    checker: Checker
    run: RunBlock[StepBlock]
    kinds: Mapping[str, StepKind]
    numeric: NumericModel
    values: Mapping[str, float]
    monitors: Mapping[str, Monitor]
    folder: FilePath
    # Parameters that are sure to hold where each step planned so far ends.
    known: dict[str, dict[str, float]] = field(default_factory=dict)
    # The files that steps have read, by what they are in words.
    inputs: dict[str, str] = field(default_factory=dict)

    def plan_step(self, i: int) -> PlannedStep[Any]:
        """Return a step of the run."""
        step, checker = self.run.steps[i], self.checker
        path: Path = ("steps", i)
        kind = self.kinds[step.kind]
        above = {s.name: s for s in self.run.steps[:i]}
        if step.name in above:
            checker.add_error((*path, "name"), f"step '{step.name}' is defined twice; names of steps differ")
        values = dict(self.values)
        assignments = {}
        for name, text in step.set.items():
            here = (*path, "set", name)
            if checker.check_settable(here, name):
                assignments[name] = checker.parse_formula(here, text)
                values[name] = checker.evaluate_formula(here, assignments[name], values)
        p = self.numeric.with_fixed(np.array([values[name] for name in checker.model.parameters], dtype=float))
        values = dict(zip(checker.model.parameters, p.tolist(), strict=True))
        self._check_own_durations((*path, "set"), step, values)
        self._check_source((*path, step.kind, "from"), step, above)
        source, origin = step.source, None
        if source is not None and source.file is None and source.step in above:
            origin = self.kinds[above[source.step].kind]
        known = self._find_known(step, assignments)
        given = StepInput(
            checker,
            (*path, step.kind),
            step.name,
            step.body,
            self.numeric,
            values,
            step.delay or self.run.delay,
            self.monitors,
            bool(step.set),
            source,
            "" if origin is None else origin.name,
            None if origin is None else origin.holds,
            known,
            self.folder,
        )
        self._check_delay_method((*path, "delay"), given)
        varied = set(kind.list_varied(step.body))
        all_may_vary = not varied and kind.holds in (Holding.BRANCH, Holding.ATTRACTORS)
        self.known[step.name] = {} if all_may_vary else {k: v for k, v in known.items() if k not in varied}
        settings = kind.resolve(given)
        self.inputs.update({f"file '{name}' of step '{step.name}'": str(self.folder / name) for name in given.files})
        return PlannedStep(
            step.name,
            step.kind,
            settings,
            source,
            assignments,
            (step.delay or self.run.delay).make_method(),
            (step.mesh or self.run.mesh).make_rule(),
            self.run.accuracy is not None and kind.takes_accuracy and step.delay is None and step.mesh is None,
            step.model_dump(mode="json", by_alias=True),
            given.files,
        )

    def _check_delay_method(self, path: Path, given: StepInput[Any]) -> None:
        """Check that a step's delay method can hold what the model reads of the past."""
        why = explain_direct_only(given.model)
        if why and given.delay.method != "direct":
            given.checker.add_error(
                path,
                f"{why}: a delay method '{given.delay.method}' holds states a constant time ago and nothing else; give "
                "'delay: {method: direct}'",
            )

    def _find_known(self, step: StepBlock, assignments: Mapping[str, ParameterFormula]) -> dict[str, float]:
        """Return the parameters that a step is sure to start with: those of where it starts, then its own."""
        source = step.source
        if source is None:
            known = dict(self.values)
        else:
            known = {} if source.file is not None else dict(self.known.get(source.step, {}))
        for name, formula in assignments.items():
            before, needed = dict(known), {symbol.name for symbol in formula.expr.free_symbols}
            known.pop(name, None)
            if needed <= set(before):
                # What has no value was noted where it was parsed.
                with contextlib.suppress(RunError):
                    known[name] = formula.evaluate(before)
        return known

    def _check_own_durations(self, path: Path, step: StepBlock, values: Mapping[str, float]) -> None:
        """Check delays and the forcing period, as far as they do not depend on where the step starts."""
        for message, names in find_wrong_durations(self.checker.model, values):
            own = [name for name in step.set if name in names]
            if own and (step.source is None or names <= set(own)):
                self.checker.add_error((*path, own[0]), message)

    def _check_source(self, path: Path, step: StepBlock, above: Mapping[str, StepBlock]) -> None:
        """Check that the step starts from one above it that holds what others can start from."""
        source = step.source
        if source is None or source.file is not None:
            return
        if source.step not in above:
            names = f"{suggest(source.step, above)} (steps above: {', '.join(above) or 'none'})"
            self.checker.add_error(path, f"step '{source.step}' is not above this one{names}")
            return
        holds = self.kinds[above[source.step].kind].holds
        is_chosen = source.point is not None or source.index is not None
        if holds == Holding.ATTRACTORS and not is_chosen:
            which = f"{{step: {source.step}, point: A1}}"
            self.checker.add_error(path, f"'{source.step}' holds many attractors; say which: {which}")
        if holds == Holding.BRANCH and not is_chosen:
            which = f"{{step: {source.step}, point: GR1}} or 'index: 0'"
            self.checker.add_error(path, f"'{source.step}' holds many orbits; say which: {which}")
        if holds == Holding.NOTHING:
            what = f"is a {above[source.step].kind} step and holds nothing to start from"
            self.checker.add_error(path, f"'{source.step}' {what}; start from the step that it starts from")

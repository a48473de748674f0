"""Steps that are computed before their turn, elsewhere: each keeps a log, which is written when its turn comes.

A step may be begun when the step that it starts from is done, written or not; nothing else is told to wait.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from typing import Any

from pddecont.errors import PddecontError
from pddecont.results import Results, Step, find_format
from pddecont.runfile import Holding, Plan, PlannedStep
from pddecont.simulate import Elsewhere, Trajectory, Turnstile, Workers
from pddecont.steps.budget import Budget
from pddecont.steps.context import Context
from pddecont.steps.execution.apart import can_read_elsewhere
from pddecont.steps.execution.log import (
    Closed,
    Entry,
    Listener,
    Message,
    Opened,
    RowsInMemory,
    step_from_log,
    write_entry,
)
from pddecont.steps.execution.one_step import do_step
from pddecont.steps.kind import Sharing
from pddecont.steps.registry import list_step_kinds


@dataclass(frozen=True, eq=False)
class StepTask:
    """A step to be computed, with what it starts from: a recorded step or the log of one, or a trajectory.

    ``file`` is what the results file says of itself; ``is_source`` says whether others start from the step; ``budget``
    is what it may spend.
    """

    step: str
    file: Results
    source: Step | Sequence[Entry] | None
    trajectories: Mapping[str, Trajectory]
    is_source: bool
    budget: Budget = field(default_factory=Budget)


@dataclass(frozen=True, eq=False)
class ComputedStep:
    """A step that was computed: its log, what went wrong at its end, and trajectories that others start from."""

    log: Sequence[Entry]
    error: PddecontError | None
    trajectories: Mapping[str, Trajectory]


def compute_step(plan: Plan, task: StepTask) -> ComputedStep:
    """Do a step as it is done when its turn comes, and keep a log of it."""
    log: list[Entry] = []
    step, file = plan.find_step(task.step), task.file
    held = task.source
    if held is not None and step.source is not None:
        source = held if isinstance(held, Step) else step_from_log(step.source.step, held)
        assert source is not None, "a step that others start from was closed"
        file = replace(file, names=(source.name,), steps={source.name: source})
    context = Context(plan, file.path, Listener(log), Workers(), dict(task.trajectories), file, budget=task.budget)

    def open_in_memory(_: Any, name: str, step_format: Any, meta: Mapping[str, Any], **options: Any) -> RowsInMemory:
        closed = options.pop("closed")
        log.append(Opened(step_format.kind, dict(meta), options))

        def keep() -> None:
            done = step_from_log(name, log)
            assert done is not None, "it was closed"
            closed(done)

        return RowsInMemory(dict(meta), log, keep)

    context.make_writer = open_in_memory
    error = None
    try:
        do_step(context, step)
    except PddecontError as exc:
        error = exc
    new = {name: found for name, found in context.trajectories.items() if name not in task.trajectories}
    return ComputedStep(log, error, new if task.is_source else {})


def write_computed(context: Context, step: PlannedStep[Any], computed: ComputedStep) -> None:
    """Write what a step that was computed elsewhere found, tell what it told, and raise what went wrong."""
    context.trajectories.update(computed.trajectories)
    with contextlib.ExitStack() as stack:
        for entry in computed.log:
            match entry:
                case Message():
                    entry.tell(context.reporter)
                case Opened():
                    opened = context.open_as(step.name, find_format(entry.kind), entry.meta, **entry.options)
                    writer = stack.enter_context(opened)
                case Closed():
                    stack.close()
                case _:
                    write_entry(writer, entry)
        if computed.error is not None:
            raise computed.error


class EarlySteps:
    """The steps of a run that may be computed before their turn, and those that are."""

    def __init__(self, context: Context, steps: Sequence[PlannedStep[Any]], elsewhere: Elsewhere):
        self._context, self._elsewhere = context, elsewhere
        kinds, file = list_step_kinds(), context.file
        held = {} if file is None else file.steps
        self._holds = {step.name: kinds[step.kind].holds for step in context.plan.steps}
        # What is in the file already is finished, or goes on from there, when its turn comes.
        self._ahead = {
            step.name: step
            for step in steps
            if kinds[step.kind].sharing == Sharing.EARLY and step.name not in held and can_read_elsewhere(context, step)
        }
        self._to_come = {step.name for step in steps}
        self._sources = {step.source.step for step in steps if step.source is not None and step.source.file is None}
        self._begun: dict[str, Future[ComputedStep]] = {}
        self._turnstile = Turnstile(self._begin_all)

    def begin(self) -> None:
        """Begin steps, as far as what they start from is done and somebody is free."""
        self._turnstile.begin()

    def _begin_all(self) -> None:
        for name, step in list(self._ahead.items()):
            task = self._make_task(step)
            future = None if task is None else self._elsewhere.begin(compute_step, task)
            if future is not None:
                self._begun[name] = future
                del self._ahead[name]

    def take(self, step: PlannedStep[Any]) -> ComputedStep | None:
        """Return what was computed of a step whose turn it is, once it is; None if it is to be done here."""
        with self._turnstile.lock:
            self._ahead.pop(step.name, None)
            begun = self._begun.get(step.name)
        return None if begun is None else self._elsewhere.wait(begun)

    def put(self, step: PlannedStep[Any]) -> None:
        """Hear that a step is in the file."""
        with self._turnstile.lock:
            self._to_come.discard(step.name)
            self._begun.pop(step.name, None)

    def end(self) -> None:
        """Begin no more."""
        self._turnstile.end()

    def _make_task(self, step: PlannedStep[Any]) -> StepTask | None:
        """Return a step with what it starts from; None if that is not done yet."""
        file = self._context.file
        assert file is not None, "a run has a file"
        name = None if step.source is None or step.source.file is not None else step.source.step
        held: Step | Sequence[Entry] | None = None
        trajectories: Mapping[str, Trajectory] = {}
        if name is not None and name in self._to_come:
            before = self._find_computed(name)
            if before is None:
                return None
            held, trajectories = before.log, before.trajectories
        elif name is not None:
            recorded, trajectories = file.steps.get(name), self._context.trajectories
            # A copy: nobody here changes it while it is sent.
            held = None if recorded is None else replace(recorded)
        if name is not None and self._holds[name] == Holding.TRAJECTORY:
            held, trajectories = None, {key: found for key, found in trajectories.items() if key == name}
        else:
            trajectories = {}
        return StepTask(step.name, replace(file, names=(), steps={}), held, trajectories, step.name in self._sources)

    def _find_computed(self, name: str) -> ComputedStep | None:
        """Return what was computed of a step that is not in the file yet; None if that cannot be started from."""
        begun = self._begun.get(name)
        if begun is None or not begun.done() or begun.cancelled() or begun.exception() is not None:
            return None
        computed = begun.result()
        return computed if computed.error is None else None


@contextlib.contextmanager
def compute_early(context: Context, steps: Sequence[PlannedStep[Any]], elsewhere: Elsewhere) -> Iterator[EarlySteps]:
    """Yield the steps of a run that are computed early; none is begun when the context has ended."""
    early = EarlySteps(context, steps, elsewhere)
    elsewhere.slots.on_free = early.begin
    try:
        yield early
    finally:
        early.end()

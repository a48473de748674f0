"""The directions of a branch, at once where there are workers: one here, the others elsewhere, all written here."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, replace
from typing import Any

from pddecont.errors import PddecontError
from pddecont.reasons import Reason
from pddecont.results import Results, Row, RowWriter
from pddecont.runfile import Plan, PlannedStep
from pddecont.simulate import Workers
from pddecont.steps.budget import Budget, OutOfTimeError
from pddecont.steps.context import Context
from pddecont.steps.continuation import ContinueSettings
from pddecont.steps.execution.accuracy import choose_settings
from pddecont.steps.execution.log import RowsInMemory, write_entry
from pddecont.steps.reporter import Silent

# Follows a direction (+1 or -1) of a step's branch from its start; returns how it ended.
Follow = Callable[[Context, PlannedStep[ContinueSettings], RowWriter, int], Reason]


@dataclass(frozen=True, eq=False)
class DirectionTask:
    """A direction to be followed: what the file holds of where the step starts, and what it says of the step.

    ``steps`` are the step and the one that it starts from, which an exploration may have planned after those that do it
    began; ``budget`` is what the direction may spend.
    """

    follow: Follow
    file: Results
    steps: Sequence[PlannedStep[Any]]
    meta: Mapping[str, Any]
    way: int
    budget: Budget


@dataclass(frozen=True, eq=False)
class FollowedDirection:
    """A direction that was followed: its points and how it ended, or what went wrong, or that the time is over."""

    rows: Sequence[Row]
    ending: Reason | None
    error: PddecontError | OutOfTimeError | None = None


def follow_directions(
    context: Context,
    step: PlannedStep[ContinueSettings],
    writer: RowWriter,
    ways: Sequence[int],
    endings: Mapping[int, Reason],
    follow_here: Callable[[int], Reason],
    follow: Follow,
    find_ending: Callable[[int, Collection[Reason]], Reason | None] = lambda way, endings: None,
) -> None:
    """Follow the directions of a branch that have not ended, and write them one after another.

    ``follow_here`` follows one from where it stands, ``follow`` from its start; ``find_ending`` returns how one ends
    that need not be followed, given the others that ended.
    """
    ended = dict(endings)
    to_do = [way for way in ways if way not in ended]
    begun = _begin_apart(context, step, writer, to_do[1:], follow)
    if context.elsewhere is not None:
        # What may be early takes what places these leave.
        context.elsewhere.slots.on_free()
    for way in to_do:
        ending = find_ending(way, ended.values())
        if ending is None and way in begun:
            ending = _take_in(context, writer, begun[way])
        ended[way] = follow_here(way) if ending is None else ending
        writer.terminate(ended[way], ways.index(way))


def _begin_apart(
    context: Context, step: PlannedStep[ContinueSettings], writer: RowWriter, ways: Sequence[int], follow: Follow
) -> dict[int, Future[FollowedDirection]]:
    """Begin to follow directions elsewhere, as far as somebody is free there."""
    elsewhere, file, source = context.elsewhere, context.file, step.source
    if elsewhere is None or file is None or not can_read_elsewhere(context, step):
        return {}
    # Of the file only the step is needed that this one starts from. A copy: nobody here changes it while it is sent.
    held = None if source is None else file.steps.get(source.step)
    file = replace(file, steps={} if held is None else {held.name: replace(held)})
    names = [step.name] if source is None or source.file is not None else [step.name, source.step]
    steps = [planned for planned in context.plan.steps if planned.name in names]
    # Clocks of other machines tell another time.
    budget = Budget() if elsewhere.on_cluster else context.budget
    tasks = {way: DirectionTask(follow, file, steps, dict(writer.meta), way, budget) for way in ways}
    begun = {way: elsewhere.begin(follow_apart, task) for way, task in tasks.items()}
    return {way: future for way, future in begun.items() if future is not None}


def can_read_elsewhere(context: Context, step: PlannedStep[Any]) -> bool:
    """Return whether others can read where a step starts: not another file from a cluster, which need not have it."""
    if step.source is None or step.source.file is None:
        return True
    on_cluster = context.elsewhere is not None and context.elsewhere.on_cluster
    return not on_cluster and (context.plan.base / step.source.file).resolve() != context.path.resolve()


def _take_in(context: Context, writer: RowWriter, begun: Future[FollowedDirection]) -> Reason | None:
    """Write the points of a direction that was followed elsewhere; return how it ended, or None if it was not."""
    assert context.elsewhere is not None, "it was begun there"
    followed = context.elsewhere.wait(begun)
    if followed is None:
        context.elsewhere.slots.sit()
        return None
    for row in followed.rows:
        write_entry(writer, row)
    if followed.error is not None:
        raise followed.error
    context.reporter.progress(f"{writer.n} points")
    return followed.ending


def follow_apart(plan: Plan, task: DirectionTask) -> FollowedDirection:
    """Follow one direction of a branch from its start; what it records and how it ends are those of the whole step."""
    known = {step.name for step in plan.steps}
    plan = replace(plan, steps=(*plan.steps, *(step for step in task.steps if step.name not in known)))
    context = Context(plan, task.file.path, Silent(), Workers(), file=task.file, budget=task.budget)
    writer = RowsInMemory(dict(task.meta))
    ending: Reason | None = None
    error: PddecontError | OutOfTimeError | None = None
    try:
        step = choose_settings(context, task.steps[-1], task.meta.get("choice"))
        ending = task.follow(context, step, writer, task.way)
    except (PddecontError, OutOfTimeError) as exc:
        error = exc
    return FollowedDirection([entry for entry in writer.log if isinstance(entry, Row)], ending, error)

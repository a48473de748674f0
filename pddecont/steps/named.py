"""What the expressions of a run name: what a model without some of its effects must keep for them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from pddecont.model.reduction import Named
from pddecont.steps.schema import Initial, RunBlock, Step

WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def named_in(run: RunBlock) -> Named:
    """Return the identifiers in a run's expressions, grids and boxes, and the modes that its motions are put into.

    Initial values and histories need no state: they say where it begins if it is there.
    """
    texts = [*run.monitors.values(), *(text for step in run.steps for text in _texts(step))]
    modes = frozenset(mode for step in run.steps for mode in _modes(step))
    return Named(frozenset(word for text in texts for word in WORD.findall(str(text))), modes)


def _texts(step: Step) -> Iterator[Any]:
    if step.continue_:
        yield from step.continue_.events_along.values()
    if step.precision:
        yield from step.precision.quantities.values()
    if step.simulate:
        yield from step.simulate.record.signals.values()
    settling = step.sweep or step.basin
    if settling and settling.section and settling.section.zero is not None:
        yield settling.section.zero
    if step.sweep and step.sweep.random:
        yield from step.sweep.random.box
    if step.basin:
        yield from step.basin.over


def _modes(step: Step) -> Iterator[str]:
    body = step.simulate or step.sweep or step.basin
    if body is None:
        return
    yield from body.stick.values()
    initials = body.initial if isinstance(body.initial, list) else [body.initial]
    yield from (initial.mode for initial in initials if isinstance(initial, Initial) and initial.mode is not None)

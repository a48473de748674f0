"""Modes in which motions rest that a run names, as ``stick`` of its steps does, not the model."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from pddecont.model.derived_modes import DerivedModes
from pddecont.model.rest import find_resets_to_rest, make_resting
from pddecont.model.system import Model
from pddecont.model.transitions import list_leaders


def add_rests(model: Model, sticks: Iterable[tuple[str, str]]) -> Model:
    """Return a model in which impacts that accumulate at events come to rest in modes: pairs (event, mode)."""
    if model.derived is not None:
        return _add_to_equations(model, model.derived, sticks)
    segments = dict(model.segments)
    for event, mode in sticks:
        for segment in list_leaders(s for s in model.segments.values() if s.event == event):
            resting = make_resting(segment, segment.written or segment.name, mode)
            if mode in model.modes and resting.name not in segments:
                segments[resting.name] = resting
    if len(segments) == len(model.segments):
        return model
    parts = model.state_symbols, frozenset(model.delayed_symbols), model.modes, model.events, model.resets
    return replace(model, segments=segments, resets={**model.resets, **find_resets_to_rest(*parts, segments)})


def _add_to_equations(model: Model, derived: DerivedModes, sticks: Iterable[tuple[str, str]]) -> Model:
    known = {(event, mode) for event, mode in sticks if event in model.events and mode in model.modes}
    new = sorted(known.difference(derived.sticks.modes))
    if not new:
        return model
    now = derived.add_sticks(new, model.delayed_symbols)
    return replace(model, **now.parts, derived=now)

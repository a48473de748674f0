"""Modes in which motions rest that a run names, as ``stick`` of its steps does, not the model."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from pddecont.model.rest import find_resets_to_rest, make_resting
from pddecont.model.system import Model
from pddecont.model.transitions import list_leaders


def add_rests(model: Model, sticks: Iterable[tuple[str, str]]) -> Model:
    """Return a model in which impacts that accumulate at events come to rest in modes: pairs (event, mode)."""
    named = [(event, mode) for event, mode in sticks if mode in model.modes]
    if model.derived is not None:
        derived = model.derived.add_rests(named, model.read_symbols)
        return model if derived is model.derived else replace(model, derived=derived, **derived.parts)
    segments = dict(model.segments)
    for event, mode in named:
        for segment in list_leaders(s for s in model.segments.values() if s.event == event):
            resting = make_resting(segment, segment.written or segment.name, mode)
            if resting.name not in segments:
                segments[resting.name] = resting
    if len(segments) == len(model.segments):
        return model
    parts = model.state_symbols, frozenset(model.read_symbols), model.modes, model.events, model.resets
    return replace(model, segments=segments, resets={**model.resets, **find_resets_to_rest(*parts, segments)})

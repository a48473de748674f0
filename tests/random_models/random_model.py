"""A model of a family drawn at random: as a mapping for the program, and as a motion for the method of steps."""

from __future__ import annotations

from dataclasses import dataclass, field

from tests.models.method_of_steps import Exit, Motion, same
from tests.random_models.formula import Formula, compile_formula, compile_formulas

DIRECTIONS = {"rising": 1, "falling": -1, "any": 0}


@dataclass(frozen=True)
class Segment:
    """What ends a mode: event, direction, name of a reset (None: identity), next mode."""

    mode: str
    event: str
    direction: str
    reset: str | None
    to: str


@dataclass(frozen=True)
class RandomModel:
    """A model, the parameter to follow it in, and where its sweep looks.

    ``events`` maps names to a formula or to (source, delay), a delayed event; ``resets`` to the states that change.
    ``delays`` are the parameters that are delays of states, ``period`` the forcing's. ``section`` is the sweep's, None
    for once a forcing period. ``kinds`` name the kinds of its delays where they are drawn too.
    """

    seed: int
    family: str
    states: tuple[str, ...]
    parameters: dict[str, float]
    delays: tuple[str, ...]
    modes: dict[str, dict[str, Formula]]
    initial: dict[str, float | str]
    free: str
    span: tuple[float, float]
    events: dict[str, Formula | tuple[str, str]] = field(default_factory=dict)
    resets: dict[str, dict[str, Formula]] = field(default_factory=dict)
    segments: dict[str, Segment] = field(default_factory=dict)
    period: Formula | None = None
    section: dict[str, str] | None = None
    settle: float = 400.0
    kinds: tuple[str, ...] = ()

    def as_mapping(self):
        """Return the model as a model file says it."""
        result = {
            "name": f"{self.family}_{self.seed}",
            "states": list(self.states),
            "parameters": dict(self.parameters),
            "modes": {m: {f"{x}'": f.yaml for x, f in flow.items()} for m, flow in self.modes.items()},
            "initial": dict(self.initial),
        }
        if self.period is not None:
            result["forcing"] = {"period": self.period.yaml}
        if self.events:
            result["events"] = {
                e: f.yaml if isinstance(f, Formula) else {"after": f[0], "delay": f[1]} for e, f in self.events.items()
            }
            result["segments"] = {s: self._segment(segment) for s, segment in self.segments.items()}
        if self.resets:
            result["resets"] = {r: {x: f.yaml for x, f in change.items()} for r, change in self.resets.items()}
        return result

    @staticmethod
    def _segment(segment):
        result = {"mode": segment.mode, "event": segment.event, "direction": segment.direction, "to": segment.to}
        return result if segment.reset is None else {**result, "reset": segment.reset}

    def motion(self, parameters, history, mode, **start):
        """Return the motion from a history at parameter values."""
        fields = {m: compile_formulas([flow[x] for x in self.states], parameters) for m, flow in self.modes.items()}
        resets = {r: self._compile_reset(change, parameters) for r, change in self.resets.items()}
        functions = {
            e: compile_formula(f, parameters) if isinstance(f, Formula) else None for e, f in self.events.items()
        }
        exits = {
            m: [
                Exit(functions[s.event], DIRECTIONS[s.direction], resets.get(s.reset, same), s.to, n, s.event)
                for n, s in self.segments.items()
                if s.mode == m
            ]
            for m in self.modes
        }
        return Motion(
            fields,
            exits,
            tuple(parameters[d] for d in self.delays),
            history,
            mode,
            clocks=self.clocks(parameters),
            **start,
        )

    def clocks(self, parameters):
        """Return the delayed events that each event starts: event -> [(delayed event, delay)]."""
        clocks: dict[str, list[tuple[str, float]]] = {}
        for event, given in self.events.items():
            if not isinstance(given, Formula):
                clocks.setdefault(given[0], []).append((event, parameters[given[1]]))
        return clocks

    def evaluate(self, formula, parameters):
        """Return the value of a formula in parameters alone."""
        return compile_formula(formula, parameters)(0.0, (), None)

    def _compile_reset(self, change, parameters):
        functions = {self.states.index(x): compile_formula(f, parameters) for x, f in change.items()}

        def reset(t, z, past):
            result = z.copy()
            for i, function in functions.items():
                result[i] = function(t, z, past)
            return result

        return reset

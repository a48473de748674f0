"""Models in other units: the same text of a model file, with every unit a parameter.

A state x in units of ``unit_x``, times in those of ``unit_t``, the parameter that is followed in those of ``unit_p``:
wherever a formula names one of them its number is divided by its unit, and what gives a state, a rate or a period is
multiplied by its own. Delays are times, so their numbers are multiplied. Formulas stay the same for all units, so a
model is compiled once.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

NAME = re.compile(r"\b([A-Za-z_]\w*)\b(\(t ?- ?\w+\))?(?!\()")


@dataclass(frozen=True)
class Units:
    """What the numbers of states, times and of the parameter that is followed are multiplied by."""

    states: tuple[float, ...] = (1.0,)
    time: float = 1.0
    parameter: float = 1.0

    def of_states(self, names):
        """Return the factor of each state; with more states than factors they take turns."""
        return {x: self.states[i % len(self.states)] for i, x in enumerate(names)}


@dataclass(frozen=True)
class Problem:
    """A model, and the parameter that its branch is followed in over a range; ``settle`` is how long it settles.

    ``settings`` are those of its run (delay, mesh), ``free_is_time`` tells that the parameter is a delay.
    """

    name: str
    model: dict
    free: str
    span: tuple[float, float]
    settle: float
    settings: dict = field(default_factory=dict)
    max_points: int = 12

    @property
    def delays(self):
        """The parameters that are delays, of states or of events."""
        texts = str(self.model)
        found = {d.strip() for d in re.findall(r"\(t ?- ?(\w+)\)", texts)}
        events = self.model.get("events", {}).values()
        return found | {e["delay"] for e in events if isinstance(e, dict)}

    def factor(self, units):
        """Return what the number of the parameter that is followed is multiplied by."""
        return units.time if self.free in self.delays else units.parameter

    def run_in(self, units):
        """Return the run in units: settle, solve, follow."""
        free, factor = self.free, self.factor(units)
        branch = {
            "from": "o",
            "free": [free],
            "range": {free: [v * factor for v in self.span]},
            "stability": True,
            "max_points": self.max_points,
        }
        states = units.of_states(self.model["states"])
        settle = {"t_end": repr(self.settle * units.time), "atol": 1e-11 * min(states.values())}
        steps = [
            # No motion is computed on a Chebyshev line.
            {"name": "t", "simulate": settle, "delay": {"method": "direct"}},
            {"name": "o", "orbit": {"from": "t", "stability": True}},
            {"name": "b", "continue": branch},
        ]
        return {**self._model_in(units), "run": {**self.settings, "steps": steps}}

    def _model_in(self, units):
        model, states = self.model, units.of_states(self.model["states"])
        scaled = dict(model["parameters"])
        for delay in self.delays:
            scaled[delay] *= units.time
        if self.free not in self.delays:
            scaled[self.free] *= units.parameter
        scaled |= {f"unit_{x}": u for x, u in states.items()}
        scaled |= {"unit_t": units.time, "unit_p": units.parameter}
        initial = {x: v * states.get(x, 1.0) if x in states else v for x, v in model["initial"].items()}
        first = model["states"][0]
        result = {
            **model,
            "parameters": scaled,
            "initial": initial,
            "modes": {
                m: {f"{x[:-1]}'": f"unit_{x[:-1]}/unit_t*({self._convert(f)})" for x, f in flow.items()}
                for m, flow in model["modes"].items()
            },
        }
        if "definitions" in model:
            result["definitions"] = {d: self._convert(f) for d, f in model["definitions"].items()}
        if "forcing" in model:
            result["forcing"] = {"period": f"unit_t*({self._convert(model['forcing']['period'])})"}
        if "events" in model:
            result["events"] = {
                e: f if isinstance(f, dict) else f"unit_{first}*({self._convert(f)})"
                for e, f in model["events"].items()
            }
        if "resets" in model:
            result["resets"] = {
                r: {x: f"unit_{x}*({self._convert(f)})" for x, f in change.items()}
                for r, change in model["resets"].items()
            }
        return result

    def _convert(self, formula):
        """Return a formula whose names mean numbers in units."""
        states, free = self.model["states"], None if self.free in self.delays else self.free

        def divide(match):
            name, ago = match[1], match[2] or ""
            unit = f"unit_{name}" if name in (*states, "t") else "unit_p" if name == free else None
            return match[0] if unit is None else f"({name}{ago}/{unit})"

        return NAME.sub(divide, str(formula))

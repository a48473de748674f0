"""A point of a step: an orbit of a branch, an equilibrium, an attractor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.api.orbit import Orbit
from pddecont.errors import ResultsError, printable
from pddecont.results import Results, Step
from pddecont.tables import holds_equilibria, make_orbit_arrays, name_kind, read_multipliers, read_roots

# Kinds of points that are stable or not: ordinary ones, ends of branches, equilibria that were found.
WITH_STABILITY = ("", "EP", "EQ")


@dataclass(frozen=True, eq=False, repr=False)
class Point:
    """A point of a step; ``values`` is its row in the step's table of points."""

    results: Results
    step: Step
    index: int
    values: Mapping[str, Any]

    @property
    def label(self) -> str:
        """Its label, empty for an ordinary point."""
        return self.step.labels[self.index]

    @property
    def kind(self) -> str:
        """What kind of special point it is, in words; empty for an ordinary point."""
        kind = self.step.kind_of(self.index)
        return name_kind(self.step, kind) if kind else ""

    @property
    def parameters(self) -> dict[str, float]:
        """Values of the parameters."""
        return {name: self.values[name] for name in self.step.meta["parameters"]}

    @property
    def state(self) -> dict[str, float]:
        """The equilibrium by state.

        Raises
        ------
        ResultsError
            If the point is none.
        """
        if not holds_equilibria(self.step):
            raise ResultsError(f"step '{self.step.name}' is a {self.step.kind} step and holds no equilibria")
        return {name: self.values[name] for name in self.step.meta["states"]}

    @property
    def spectrum(self) -> NDArray[np.complex128]:
        """Floquet multipliers by falling modulus, or characteristic roots by falling real part; none if not asked."""
        read = read_roots if holds_equilibria(self.step) else read_multipliers
        return read(self.step, self.index)

    def orbit(self) -> Orbit:
        """Return its orbit.

        Raises
        ------
        ResultsError
            If the step holds no orbits.
        """
        return Orbit(self.results, self.step, self.index, make_orbit_arrays(self.step, self.index))

    def __repr__(self) -> str:
        where = ", ".join(f"{name} = {self.values[name]:.8g}" for name in self.step.meta.get("free") or ())
        # At a point where stability changes it is neither.
        stable = self.values.get("stable") if self.step.kind_of(self.index) in WITH_STABILITY else None
        words = [f"{self.label or self.index} of step '{self.step.name}'", self.kind, where]
        words += [] if stable is None else ["stable" if stable else "unstable"]
        return printable(f"<point {', '.join(word for word in words if word)}>")

    def _repr_html_(self) -> str:
        from pddecont.notebook import render_facts
        from pddecont.plot import ViewRequest

        fixed = set(self.step.meta["parameters"]) - set(self.step.meta.get("free") or ())
        facts = {name: value for name, value in self.values.items() if name not in fixed and name != "note"}
        view = "roots" if holds_equilibria(self.step) else "orbit"
        request = ViewRequest(view, (self.step.name,), indices=(self.index,))
        title = f"{self.step.name}: {self.label or self.index}" + (f" ({self.kind})" if self.kind else "")
        return render_facts(self.results, self.step, facts, title, str(self.values.get("note") or ""), request)

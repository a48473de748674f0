"""A model in the integrator's numbers, as far as motions have come: it grows where one comes to something new."""

from __future__ import annotations

import sympy

from pddecont.codegen import ModelFunctions, NumericModel
from pddecont.delay import DelayMethod
from pddecont.model import TIME
from pddecont.native.integrator import REST, WAY
from pddecont.simulate.integrator import (
    IntegratorState,
    ParameterValues,
    System,
    Workspace,
    fit_state,
    fit_workspace,
    make_workspace,
)
from pddecont.simulate.method import Method
from pddecont.simulate.model_numbers import fit_values, make_system
from pddecont.simulate.part_tables import PartTables
from pddecont.simulate.returns import ReturnSection


class ReachedSystem:
    """Tables of what has been reached, and the system and the arrays that the integrator works with."""

    def __init__(
        self,
        numeric: NumericModel,
        functions: ModelFunctions,
        delay: DelayMethod,
        method: Method,
        section: ReturnSection,
        *,
        tangent: bool,
    ) -> None:
        self.numeric, self.functions, self.delay = numeric, functions, delay
        self.method, self.section = method, section
        self.tangent = tangent
        self.tables = PartTables(numeric.model, functions, section.expr, method.stick)
        if section.event is not None:
            self.tables.add_event(section.event)
        self._size = self.tables.size
        self._system = self._make_system()
        self._work = make_workspace(self._system)

    @property
    def system(self) -> System:
        """The model in numbers."""
        if self._size != self.tables.size:
            self._size = self.tables.size
            self._system = self._make_system()
            self._work = fit_workspace(self._work, self._system)
        return self._system

    @property
    def work(self) -> Workspace:
        """The arrays for intermediate results."""
        return self._work if self._size == self.tables.size else self._fit_work()

    def make_another(self) -> ReachedSystem:
        """Return the same as it was before anything was reached."""
        return ReachedSystem(
            self.numeric, self.functions, self.delay, self.method, self.section, tangent=bool(self.tangent)
        )

    def fit(self, values: ParameterValues, state: IntegratorState) -> tuple[ParameterValues, IntegratorState]:
        """Return the numbers at some parameters and the state of an integration with the size of the tables."""
        values = self.fit_values(values)
        return values, fit_state(state, self.system, values)

    def fit_values(self, values: ParameterValues) -> ParameterValues:
        """Return the numbers at some parameters with those of all events in the tables."""
        return fit_values(values, self.numeric, self.tables)

    def add_way(self, values: ParameterValues) -> None:
        """Add what the integrator asked for: where the segment leads that it came to the end of."""
        work = self.work
        leader, missing = int(work.asked[0]), int(work.asked[1])
        if missing == REST:
            rest = self.tables.add_rest(leader)
            self.work.asked[2:] = leader, rest
            return
        model, n, digits = self.numeric.model, self.numeric.n_states, tuple(work.digits.tolist())
        # Rounding may let two conditions hold that exclude each other.
        if missing == WAY and (model.derived is None or model.derived.surfaces.may_be(digits)):
            self.tables.add_way(leader, digits)
            return
        assert model.derived is not None, "conditions of a model by hand always decide"
        numbers: dict[sympy.Symbol, float] = {TIME: float(work.landing[0])}
        numbers |= dict(zip(model.parameter_symbols, values.p.tolist(), strict=True))
        numbers |= dict(zip(model.state_symbols, work.landing[1 : n + 1].tolist(), strict=True))
        numbers |= dict(zip(model.read_symbols, work.xd[: len(model.read_symbols)].tolist(), strict=True))
        way = self.tables.add_way(leader, model.derived.choose(self.tables.endings[leader], numbers))
        self.work.asked[2:] = leader, way

    def _fit_work(self) -> Workspace:
        _ = self.system
        return self._work

    def _make_system(self) -> System:
        return make_system(self.numeric, self.tables, self.delay, self.method, self.section, tangent=self.tangent)

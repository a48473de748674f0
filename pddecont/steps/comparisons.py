"""The problems of ``precision`` steps: what is compared, and against what."""

from __future__ import annotations

from collections.abc import Mapping

from pddecont.errors import suggest
from pddecont.model.codegen import NumericModel
from pddecont.model.expression import ExpressionError, parse
from pddecont.orbit.monitors import parse_monitor
from pddecont.steps.motions import Checker, Path
from pddecont.steps.schema import Precision, Step

OF_ORBITS, OF_RUNS = ("methods", "degrees", "intervals"), ("integrators",)


def check_precision(planner: Checker, path: Path, step: Step, values: Mapping[str, float], earlier: Mapping[str, Step]) -> None:
    """Check a precision step."""
    body = step.precision
    assert body is not None
    source = earlier.get(body.from_.step) if body.from_.file is None else None
    simulated = source is not None and source.kind == "simulate"
    if source is not None and source.kind not in ("simulate", "orbit", "continue"):
        planner.complain((*path, "from"), f"'{body.from_.step}' is a {source.kind} step; what is compared is an orbit or a simulation")
    for key in OF_ORBITS if simulated else OF_RUNS:
        if key in body.model_fields_set:
            kind = "simulations" if simulated else "orbits"
            planner.complain((*path, key), f"'{key}' does not go with {kind}", key=True)
    if simulated and step.set:
        planner.complain(path, "a comparison of simulations has the parameters of its simulate step; leave 'set' out", key=True)
    numeric = NumericModel(planner.model)
    for name, text in body.quantities.items():
        try:
            if simulated:
                parse(text, planner.model.scope("a quantity", delayed=planner.model.delayed_value))
            else:
                parse_monitor(numeric, name, text)
        except ExpressionError as exc:
            planner.complain((*path, "quantities", name), str(exc), offset=exc.offset)
    _check_reference(planner, path, body, values)


def _check_reference(planner: Checker, path: Path, body: Precision, values: Mapping[str, float]) -> None:
    for name, text in body.reference.items():
        if name not in body.quantities:
            planner.complain((*path, "reference", name), f"'{name}' is not among the quantities{suggest(name, body.quantities)} "
                                                          f"(quantities: {', '.join(body.quantities)})", key=True)  # fmt: skip
        planner.formula((*path, "reference", name), text, values)

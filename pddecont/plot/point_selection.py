"""Which points of the steps drawn are shown closely."""

from __future__ import annotations

from pddecont.errors import ResultsError
from pddecont.plot.layouts import MAX_PANELS
from pddecont.plot.several_files import list_file_names
from pddecont.plot.special_points import find_special_rows
from pddecont.plot.view import ViewRequest
from pddecont.results import Step
from pddecont.tables import holds_equilibria

# Orbits that have shrunk to equilibria.
SHRUNK = ("HB", "HH")


def select_points(
    steps: list[Step], request: ViewRequest, n: int = MAX_PANELS, *, ends: bool = True
) -> list[tuple[Step, int]]:
    """Return the points asked for, else at most ``n`` special points, else (``ends``) the first and the last.

    Raises
    ------
    ResultsError
        If there is no such label or index; indices are those of the last step.
    """
    main = steps[-1]
    asked = []
    for label in request.labels:
        step = next((s for s in reversed(steps) if label in s.labels), main)
        asked.append((step, step.row(label)))
    for i in request.indices:
        if i >= len(main):
            raise ResultsError(f"step '{main.name}' has {len(main)} points, no index {i}")
        asked.append((main, i))
    if asked:
        return asked
    special = [(step, i) for step in steps for i in find_special_rows(step)]
    outer = [(main, int(i)) for i in dict.fromkeys((main.order[0], main.order[-1]))] if ends else []
    return (special or outer)[:n]


def select_orbits(steps: list[Step], request: ViewRequest, n: int = MAX_PANELS) -> list[tuple[Step, int]]:
    """Return the points asked for whose orbits are shown beside a diagram, else at most ``n`` special points.

    Raises
    ------
    ResultsError
        If there is no such label or index, or an equilibrium is asked for, which has no orbit.
    """
    if request.labels or request.indices:
        asked = select_points(steps, request)
        rests = [
            f"point {step.labels[row] or row} of step '{step.name}'" for step, row in asked if holds_equilibria(step)
        ]
        if rests:
            raise ResultsError(
                f"{rests[0]} is an equilibrium and has no orbit to show; '--view roots' shows its characteristic roots"
            )
        return asked
    if len(list_file_names(steps)) > 1:
        # Files are compared in one diagram; orbits of some of them beside it would say nothing of the others.
        return []
    moving = [step for step in steps if not holds_equilibria(step)]
    special = [(step, i) for step in moving for i in find_special_rows(step)]
    return [(step, i) for step, i in special if step.kind_of(i) not in SHRUNK][:n]

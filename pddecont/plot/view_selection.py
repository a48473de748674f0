"""Which view a picture gives and which steps it shows: what was asked for, or what suits the file."""

from __future__ import annotations

from pddecont.errors import ResultsError
from pddecont.plot.registry import KINDS_BY_INTEREST, VIEWS
from pddecont.plot.view import View, ViewRequest, distinguish_kind
from pddecont.results import Results, Step


def find_views(step: Step) -> list[View]:
    """Return the views that show steps such as this one, its default first."""
    kind = distinguish_kind(step)
    own = [view for view in VIEWS.values() if kind in view.places] or [v for v in VIEWS.values() if v.is_default]
    found = [view for view in own if view.drawing.can_show(step)]
    return sorted(found, key=lambda view: view.places.get(kind, 0))


def list_views(step: Step) -> list[View]:
    """Return the views that can be drawn of a step by itself, its default first; none while it has no points."""
    return [view for view in find_views(step) if view.drawing.stands_alone(step)] if len(step) else []


def select_view(results: Results, request: ViewRequest) -> tuple[View, list[Step]]:
    """Return the view and the steps that it draws, the main one last.

    Raises
    ------
    ResultsError
        If there is nothing to draw so, or the steps asked for do not go with the view.
    """
    return _select_of_steps(results, request) if request.steps else _select_of_file(results, request)


def _select_of_steps(results: Results, request: ViewRequest) -> tuple[View, list[Step]]:
    steps = [results.step(name) for name in dict.fromkeys(request.steps)]
    name = request.view or next((view.name for view in find_views(steps[-1])), "")
    view = VIEWS.get(name)
    if view and view.drawing.pick_steps:
        return view, view.drawing.pick_steps(steps, results)
    for step in steps:
        if not len(step):
            raise ResultsError(f"step '{step.name}' has no points yet")
        if name not in (known := [other.name for other in find_views(step)]):
            n_free = len(step.meta.get("free") or [])
            free = f" in {n_free} parameter{'s'[: n_free - 1]}" if n_free else ""
            raise ResultsError(
                f"step '{step.name}' is a{'n' * (step.kind[0] in 'aeiou')} {step.kind} step{free}; it can be drawn as "
                f"{', '.join(known) or 'nothing yet'}, not as {name}"
            )
    assert view is not None
    if len(steps) > 1 and not all(distinguish_kind(step) in view.together for step in steps):
        raise ResultsError(f"the view '{name}' shows one step; choose one of {', '.join(s.name for s in steps)}")
    view.drawing.check_steps(steps)
    return view, steps


def _select_of_file(results: Results, request: ViewRequest) -> tuple[View, list[Step]]:
    full = sorted((s for s in results.steps.values() if len(s) and find_views(s)), key=_rank_interest)
    name = request.view or (find_views(full[-1])[0].name if full else "")
    fitting = [s for s in full if name in (view.name for view in find_views(s))]
    if not fitting:
        wanted = f" as {name}" if name else ""
        raise ResultsError(
            f"{results.path} holds nothing to draw{wanted} (steps: {', '.join(results.steps) or 'none'}); "
            "'pddecont plot --list' says what there is"
        )
    view = VIEWS[name]
    choose = view.drawing.choose_steps
    return view, choose(fitting, results, request) if choose else fitting[-1:]


def _rank_interest(step: Step) -> int:
    return next((rank for rank, kinds in enumerate(KINDS_BY_INTEREST) if step.kind in kinds), -1)

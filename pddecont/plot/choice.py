"""What a picture shows: the steps and the view that were asked for, or those that suit the file."""

from __future__ import annotations

from dataclasses import dataclass

from pddecont.errors import ResultsError
from pddecont.plot.columns import agree, default_height, free_of
from pddecont.plot.diagram import special_rows
from pddecont.plot.manifold import signals, within_plane
from pddecont.results.precision import distances
from pddecont.results.reader import Results, Step
from pddecont.results.tables import has_multipliers

# Views that show one step at a time.
SINGLE = ("orbit", "profile", "trajectory", "multipliers", "precision", "animate")
MAX_PANELS = 6


@dataclass(frozen=True)
class View:
    """What to draw; what is left out is chosen by the file's contents."""

    kind: str | None = None
    steps: tuple[str, ...] = ()
    x: str | None = None
    y: str | None = None
    z: str | None = None
    labels: tuple[str, ...] = ()
    indices: tuple[int, ...] = ()


def kinds_for(step: Step) -> tuple[str, ...]:
    """Return the views of a step, the one that suits it best first."""
    if step.kind == "continue" and len(free_of(step)) == 2:
        return "plane", "diagram", "manifold", "orbit", "profile", "multipliers", "animate"
    if step.kind == "precision":
        return ("precision", "distance") if distances(step) else ("precision",)
    return {"simulate": ("trajectory",), "sweep": ("sweep",), "basin": ("basin",), "orbit": ("orbit", "profile", "multipliers"),
            "continue": ("diagram", "orbit", "profile", "multipliers", "manifold", "animate")}.get(step.kind, ())  # fmt: skip


def views_of(step: Step) -> tuple[str, ...]:
    """Return the views that can be drawn of a step by itself, the one that suits it best first; none while it has no points."""
    if not len(step):
        return ()
    missing = {"manifold": len(free_of(step)) < 2, "multipliers": not has_multipliers(step), "animate": len(step) < 2}
    return tuple(kind for kind in kinds_for(step) if not missing.get(kind))


def choose(results: Results, view: View) -> tuple[str, list[Step]]:
    """Return the kind of view and the steps it draws, the main one last.

    Raises
    ------
    ResultsError
        If there is nothing to draw so, or the steps asked for do not go with the view.
    """
    return _asked(results, view) if view.steps else _suitable(results, view)


def _asked(results: Results, view: View) -> tuple[str, list[Step]]:
    steps = [results.step(name) for name in dict.fromkeys(view.steps)]
    kind = view.kind or next(iter(kinds_for(steps[-1])), "")
    if kind == "sweep":
        return kind, _swept(steps)
    for step in steps:
        if not len(step):
            raise ResultsError(f"step '{step.name}' has no points yet")
        if kind not in kinds_for(step):
            free = f" in {len(free_of(step))} parameter{'s'[: len(free_of(step)) - 1]}" if free_of(step) else ""
            raise ResultsError(f"step '{step.name}' is a{'n' * (step.kind == 'orbit')} {step.kind} step{free}; it can be drawn as "
                               f"{', '.join(kinds_for(step)) or 'nothing yet'}, not as {kind}")  # fmt: skip
    together = kind == "orbit" and all(s.kind == "orbit" for s in steps)
    if kind in SINGLE and len(steps) > 1 and not together:
        raise ResultsError(f"the view '{kind}' shows one step; choose one of {', '.join(s.name for s in steps)}")
    if kind == "plane" and len({frozenset(free_of(s)) for s in steps}) > 1:
        pairs = "; ".join(f"{s.name}: {', '.join(free_of(s))}" for s in steps)
        raise ResultsError(f"the curves are in different parameters ({pairs}); choose steps with the same pair")
    return kind, steps


def _suitable(results: Results, view: View) -> tuple[str, list[Step]]:
    full = [s for s in results.steps.values() if len(s) and kinds_for(s)]
    full = [s for kind in ("simulate", "orbit", "basin", "continue", "sweep", "precision") for s in full if s.kind == kind]
    kind = view.kind or (kinds_for(full[-1])[0] if full else "")
    fit = [s for s in full if kind in kinds_for(s)]
    if not fit:
        wanted = f" as {kind}" if kind else ""
        raise ResultsError(f"{results.path} holds nothing to draw{wanted} (steps: {', '.join(results.steps) or 'none'}); "
                           "'pddecont plot --list' says what there is")  # fmt: skip
    if kind == "multipliers":
        fit = [s for s in fit if has_multipliers(s)] or fit
    if kind == "sweep":
        return kind, _swept([s for s in full if s.kind == "continue" or free_of(s) == free_of(fit[-1])])
    if kind in SINGLE:
        return kind, fit[-1:]
    if kind == "distance":
        return kind, fit[-MAX_PANELS:]
    if kind == "basin":
        return kind, [s for s in fit if s.meta["over"] == fit[-1].meta["over"]][-MAX_PANELS:]
    if kind == "manifold" and view.x and view.y and {view.x, view.y} <= set(signals(fit[-1])):
        return kind, fit[-1:]
    if kind == "manifold":
        found = within_plane(fit, *pair(fit, view))
        if not found:
            raise ResultsError(f"{results.path} has no branch or curve in {' and '.join(pair(fit, view))}")
        return kind, found
    fit = [s for s in fit if kind != "diagram" or len(free_of(s)) == 1] or fit
    return kind, [s for s in fit if set(free_of(s)) == set(free_of(fit[-1]))]


def _swept(steps: list[Step]) -> list[Step]:
    """Return the sweeps among ``steps``, after the branches in the same parameter that may be drawn over them."""
    sweeps = [s for s in steps if s.kind == "sweep" and len(s)]
    if not sweeps:
        raise ResultsError("a brute-force diagram needs a sweep step with points")
    free = free_of(sweeps[-1])
    others = [name for name in sweeps[-1].meta["parameters"] if name not in free]
    branches = [s for s in steps if s.kind == "continue" and len(s) and free_of(s) == free and agree(s, sweeps[-1], others)]
    return [*branches, *sweeps]


def pair(steps: list[Step], view: View) -> tuple[str, str]:
    """Return the two parameters of a plane: those asked for, else the free parameters of the first curve."""
    free = next((free_of(s) for s in steps if len(free_of(s)) == 2), [])
    if not free and not (view.x and view.y):
        raise ResultsError("there is no curve in two parameters to say which plane is meant; give -x and -y")
    x = view.x or next(name for name in free if name != view.y)
    return x, view.y or next(name for name in free if name != x)


def height(steps: list[Step], view: View) -> str:
    """Return what a view in three dimensions shows upwards."""
    return view.z or default_height(steps[0])


def chosen_rows(steps: list[Step], view: View, n: int = MAX_PANELS, *, ends: bool = True) -> list[tuple[Step, int]]:
    """Return the points shown closely: those asked for, else the special points, else (``ends``) the first and the last."""
    main = steps[-1]
    asked = []
    for name in view.labels:
        step = next((s for s in reversed(steps) if name in s.labels), main)
        asked.append((step, step.row(name)))
    for i in view.indices:
        if i >= len(main):
            raise ResultsError(f"step '{main.name}' has {len(main)} points, no index {i}")
        asked.append((main, i))
    if asked:
        return asked
    special = [(step, i) for step in steps for i in special_rows(step)]
    outer = [(main, int(i)) for i in dict.fromkeys((main.order[0], main.order[-1]))] if ends else []
    return (special or outer)[:n]

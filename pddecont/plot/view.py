"""What a view is: its name, the kinds of steps that it shows, and how it is drawn."""

from __future__ import annotations

import pkgutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from pddecont.memo import cached_property

if TYPE_CHECKING:
    from matplotlib.animation import Animation
    from matplotlib.figure import Figure

    from pddecont.results import Results, Step


# What branches are in two free parameters, by their recorded kind.
CURVES = {"continue": "curve", "equilibria": "equilibrium_curve"}


@dataclass(frozen=True)
class ViewRequest:
    """What somebody asks to see; what is left out is chosen by the file's contents.

    ``view`` and ``steps`` are names; ``x``, ``y`` and ``z`` name what the axes show; ``labels`` and ``indices`` say
    which points are shown closely.
    """

    view: str | None = None
    steps: tuple[str, ...] = ()
    x: str | None = None
    y: str | None = None
    z: str | None = None
    labels: tuple[str, ...] = ()
    indices: tuple[int, ...] = ()


def accept_step(step: Step) -> bool:
    """Return True: for views that ask nothing of a step beyond its kind."""
    return True


def accept_steps(steps: list[Step]) -> None:
    """Raise nothing: for views that show steps together whatever they hold."""


@dataclass(frozen=True)
class Drawing:
    """How a view is drawn, and what it asks of steps beyond their kinds.

    Parameters
    ----------
    draw
        Returns the figure of some steps, the main one last; of a moving view the animation.
    can_show
        Whether a step of one of the view's kinds can be drawn so.
    stands_alone
        Whether such a step by itself holds all that is drawn.
    choose_steps
        Returns what is drawn when no step is named, of the steps of a file that can be drawn so; without it the last.
    check_steps
        Raises :class:`ResultsError` if steps that were named do not go together.
    pick_steps
        Stands in place of all checks where steps of other kinds may be named too, or others of the file go with them:
        returns those that are drawn.
    """

    draw: Callable[[list[Step], ViewRequest], Figure | Animation]
    can_show: Callable[[Step], bool] = accept_step
    stands_alone: Callable[[Step], bool] = accept_step
    choose_steps: Callable[[list[Step], Results, ViewRequest], list[Step]] | None = None
    check_steps: Callable[[list[Step]], None] = accept_steps
    pick_steps: Callable[[list[Step], Results], list[Step]] | None = None


@dataclass(frozen=True)
class View:
    """One way to draw steps, as it stands in the registry.

    Parameters
    ----------
    name
        What ``pddecont plot --view`` takes.
    description
        What the command's help says of it.
    source
        Its :class:`Drawing`, or where that stands (``package.module:NAME``): it is imported when it is first needed, so
        that views can be listed without numpy.
    places
        The kinds of steps that it shows (as :func:`distinguish_kind` calls them), each with the view's place among the
        views of that kind: the first is what is drawn when no view is named.
    together
        Those of these kinds of which it shows several steps in one picture.
    is_moving
        Whether it is an animation.
    in_overview
        Whether a report shows it once for the whole file and not for each step.
    is_default
        Whether it shows the kinds of steps that no other view shows.
    """

    name: str
    description: str
    source: Drawing | str
    places: Mapping[str, int] = field(default_factory=dict)
    together: tuple[str, ...] = ()
    is_moving: bool = False
    in_overview: bool = False
    is_default: bool = False

    @cached_property
    def drawing(self) -> Drawing:
        """How it is drawn."""
        found = pkgutil.resolve_name(self.source) if isinstance(self.source, str) else self.source
        assert isinstance(found, Drawing)
        return found


def distinguish_kind(step: Step) -> str:
    """Return the recorded kind of a step, but that of a curve for a branch in two free parameters."""
    return CURVES.get(step.kind, step.kind) if len(step.meta.get("free") or []) == 2 else step.kind

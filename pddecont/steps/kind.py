"""A kind of step, declared once: how it is written, what it keeps, who does it."""

from __future__ import annotations

import pkgutil
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar

from pddecont.model import Strict
from pddecont.results import StepFormat
from pddecont.runfile import Holding, PlannedStep, StepInput

if TYPE_CHECKING:
    from pddecont.results import Step
    from pddecont.steps.context import Context

F = TypeVar("F", bound=Strict)
S = TypeVar("S")
# Does a step; the last argument is what the results file holds of it already.
Runner: TypeAlias = "Callable[[Context, PlannedStep[Any], Step | None], None]"


class Sharing(StrEnum):
    """How a step of a kind shares the run's workers with other steps.

    ``EARLY``: it takes one, and may be computed in another process before its turn. ``POOL``: it is computed in this
    process when its turn comes, on all workers as they get free. ``ALONE``: so is it, while nothing else is computed.
    """

    EARLY = "early"
    POOL = "pool"
    ALONE = "alone"


def _list_nothing(body: Any) -> Iterable[Any]:
    return ()


@dataclass(frozen=True, eq=False)
class StepKind(Generic[F, S]):
    """One kind of step.

    Attributes
    ----------
    name
        The key that names it in run files.
    fields
        What a file may say under that key.
    resolve
        Return what a step is to do, names and formulas resolved against the model; note what is wrong with it.
    format
        What it keeps in a results file.
    run
        Does a step and records it, or its place as ``module:name``, so that what it needs is imported by runs that have
        one alone. It is given what the file holds of an unfinished step, to continue from, if the kind ``resumes``.
    resumes
        Whether an unfinished step is continued; otherwise it is begun anew.
    holds
        What a step leaves that others can start from.
    takes_accuracy
        Whether the run's accuracy decides its delay and mesh.
    sharing
        How it shares the run's workers with other steps. A step that is computed early starts from ``source`` alone
        and does all that others see through its context.
    plans
        Kinds of the steps that it plans and does itself.
    list_names, list_modes
        Texts whose names the model must have, and modes that motions are put into, whichever effects are left out.
    list_sticks
        Events at which impacts accumulate, each with the mode in which the motion rests then.
    list_varied
        Parameters that do not have one value throughout a step.
    """

    name: str
    fields: type[F]
    resolve: Callable[[StepInput[F]], S]
    format: StepFormat
    run: Callable[[Context, PlannedStep[S], Step | None], None] | str
    resumes: bool = False
    holds: Holding = Holding.NOTHING
    takes_accuracy: bool = False
    sharing: Sharing = Sharing.ALONE
    plans: tuple[str, ...] = ()
    list_names: Callable[[F], Iterable[Any]] = _list_nothing
    list_modes: Callable[[F], Iterable[str]] = _list_nothing
    list_sticks: Callable[[F], Iterable[tuple[str, str]]] = _list_nothing
    list_varied: Callable[[F], Iterable[str]] = _list_nothing

    def load(self) -> Runner:
        """Return what does a step of the kind."""
        run: Runner = pkgutil.resolve_name(self.run) if isinstance(self.run, str) else self.run
        return run

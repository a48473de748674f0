"""What a run file's loader needs of a kind of step: how it is written, what becomes of that, what others start from."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Protocol

from pddecont.model import Strict
from pddecont.runfile.holding import Holding
from pddecont.runfile.step_input import StepInput


class StepKind(Protocol):
    """A kind of step, as far as its text goes."""

    @property
    def name(self) -> str:
        """The key that names it in a file."""
        ...

    @property
    def fields(self) -> type[Strict]:
        """What is under that key."""
        ...

    @property
    def holds(self) -> Holding:
        """What steps of the kind leave for others."""
        ...

    @property
    def takes_accuracy(self) -> bool:
        """Whether the run's accuracy decides its delay and mesh."""
        ...

    def resolve(self, given: StepInput[Any], /) -> Any:
        """Return what a step is to do, with names and formulas resolved; note what is wrong with it."""
        ...

    def list_names(self, body: Any, /) -> Iterable[Any]:
        """Return the texts whose names the model must have, whichever effects are left out."""
        ...

    def list_modes(self, body: Any, /) -> Iterable[str]:
        """Return the modes that motions of a step are put into."""
        ...

    def list_sticks(self, body: Any, /) -> Iterable[tuple[str, str]]:
        """Return the events at which impacts accumulate, each with the mode in which the motion rests then."""
        ...

    def list_varied(self, body: Any, /) -> Iterable[str]:
        """Return the parameters that do not have one value throughout a step."""
        ...

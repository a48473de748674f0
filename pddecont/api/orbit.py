"""An orbit as arrays by name, which a notebook draws."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from pddecont.errors import printable
from pddecont.results import Results, Step
from pddecont.tables import find_signature, make_frame, make_table

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True, eq=False, repr=False)
class Orbit(Mapping[str, NDArray[Any]]):
    """An orbit at its base points: ``t``, ``segment`` (from 1) and each state, arrays of one length."""

    results: Results
    step: Step
    index: int
    arrays: Mapping[str, NDArray[Any]]

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Return a column."""
        return self.arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.arrays)

    def __len__(self) -> int:
        return len(self.arrays)

    @property
    def period(self) -> float:
        """The orbit's duration."""
        return float(self.step.points["period"][self.index])

    @property
    def signature(self) -> tuple[str, ...]:
        """Names of its segments in order."""
        return tuple(find_signature(self.step, self.index).split())

    def to_pandas(self) -> pandas.DataFrame:
        """Return its columns as a data frame, with units in ``attrs``. Needs pandas.

        Raises
        ------
        ResultsError
            If pandas is not installed.
        """
        return make_frame(self.step, "orbit", make_table(self.step, "orbit", self.index))

    def __repr__(self) -> str:
        return printable(
            f"<orbit {_name_point(self.step, self.index)} of step '{self.step.name}', period {self.period:.8g}, "
            f"{len(self.arrays['t'])} base points, signature {' '.join(self.signature) or 'without events'}>"
        )

    def _repr_html_(self) -> str:
        from pddecont.notebook import render_facts
        from pddecont.plot import ViewRequest

        facts = {"period": self.period, "base points": len(self.arrays["t"]), "signature": " ".join(self.signature)}
        facts |= {f"lowest_{name}": float(self[name].min()) for name in self.step.meta["states"]}
        facts |= {f"highest_{name}": float(self[name].max()) for name in self.step.meta["states"]}
        request = ViewRequest("profile", (self.step.name,), indices=(self.index,))
        title = f"{self.step.name}: orbit {_name_point(self.step, self.index)}"
        return render_facts(self.results, self.step, facts, title, request=request)


def _name_point(step: Step, index: int) -> str:
    return step.labels[index] or str(index)

"""Where a motion starts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class InitialState:
    """Where a motion starts: states (n_states,), mode, and whether the states are its history too.

    Without a mode it is read from the states.
    """

    states: NDArray[np.float64]
    mode: str | None
    constant: bool

"""What compiled functions are given by Python: numbers one after the other, arrays of several dimensions row by row."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
# What sparse matrices number their rows and columns with.
Indices = NDArray[np.intc]
Function = TypeVar("Function", bound=Callable[..., Any])


def entry(function: Function) -> Function:
    """Mark a function that Python calls; compiled, it takes arrays as Python has them and lets other threads run."""
    return function


def wide(function: Function) -> Function:
    """Mark a function with long loops; compiled, it uses registers as wide as the processor has them."""
    return function

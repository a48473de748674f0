"""Where periodic orbits are born: a Hopf point with its normal form, and how fast orbits grow from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.continuation import factor
from pddecont.equilibrium.equations import Equilibrium
from pddecont.equilibrium.normal_forms import Forms, find_cubic_coefficient, find_root_speed
from pddecont.equilibrium.stability import find_own_roots
from pddecont.errors import ConvergenceError

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
# Length of the steps over which Delta is differentiated along the branch, in widths of the parameter's range.
DIFFERENCE = 1e-5
# A pair farther from the imaginary axis than this, relative to its frequency, is none of a Hopf point.
ON_AXIS = 1e-3


@dataclass(frozen=True, eq=False)
class Birth:
    """A Hopf point: the ``frequency`` omega, the ``vector`` q (n_states,) with |q| = 1, and the coefficient l1.

    Orbits x + 2 Re(z q e^(i omega t)) have |z|^2 = ``growth`` times the parameter's distance from the point; they lie
    on the side where that is positive. Coefficient and growth are NaN where the mode slides.
    """

    equilibrium: Equilibrium
    frequency: float
    vector: Complex
    coefficient: float
    growth: float


def find_birth(at: Equilibrium, free: int, width: float, frequency: float | None = None) -> Birth:
    """Return what is known of a Hopf point for the parameter numbered ``free`` with a range of that ``width``.

    Of several pairs on the imaginary axis it is that nearest to a ``frequency``.

    Raises
    ------
    ConvergenceError
        If no pair of roots lies on the imaginary axis.
    """
    values = find_own_roots(at.motion, at.states, at.parameters).values
    pairs = values[values.imag > 0.0]
    away = np.abs(pairs.real if frequency is None else pairs - 1j * frequency)
    nearest = complex(pairs[int(np.argmin(away))]) if len(pairs) else 0.0j
    if not abs(nearest.real) <= ON_AXIS * nearest.imag or nearest == 0.0:
        raise ConvergenceError("no pair of characteristic roots lies on the imaginary axis here")
    omega = nearest.imag
    forms = Forms(at)
    critical = forms.find_critical(1j * omega)
    if at.motion.surfaces:
        return Birth(at, omega, critical.right, np.nan, np.nan)
    cubic = find_cubic_coefficient(forms, critical)
    before, after = (_move(at, free, sign * DIFFERENCE * width) for sign in (-1.0, 1.0))
    speed = find_root_speed(critical, before, after, 2.0 * DIFFERENCE * width)
    return Birth(at, omega, critical.right, cubic.real / omega, -speed.real / cubic.real if cubic.real else np.inf)


def find_other_frequency(at: Equilibrium, own: float) -> float:
    """Return the frequency of the pair next to the imaginary axis that is not the one of the frequency ``own``.

    Raises
    ------
    ConvergenceError
        If there is none.
    """
    values = find_own_roots(at.motion, at.states, at.parameters).values
    pairs = values[values.imag > 0.0]
    pairs = np.delete(pairs, np.argmin(np.abs(pairs - 1j * own)))
    if not len(pairs) or not np.min(np.abs(pairs.real)) <= ON_AXIS * own:
        raise ConvergenceError("no second pair of characteristic roots lies on the imaginary axis here")
    return float(pairs[int(np.argmin(np.abs(pairs.real)))].imag)


def _move(at: Equilibrium, free: int, distance: float) -> Equilibrium:
    """Return the equilibrium at a parameter a little apart, to the first order."""
    _, in_x, in_p = at.motion.differentiate(at.states, at.parameters, (free,))
    solve: Any = factor(in_x)
    p = at.parameters.copy()
    p[free] += distance
    return Equilibrium(at.motion, at.states - distance * np.asarray(solve(in_p[:, 0])), p)

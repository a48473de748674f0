"""Exact solutions and reference numbers that the tests compare with, each with its source or derivation."""

from __future__ import annotations

import math

# Wall x <= .2, v+ = -.8 v-, x'' + .1 x' + x = cos 2t, period pi. The flight is a linear oscillation with two constants, fixed
# by x = .2 at both ends and v(end) = -v(start)/.8; root of the remaining scalar equation. (shared validation table)
WALL = {"t_hit": 1.0849389538, "v_out": -2.4554898724}

# Bouncing ball on a table A sin(wt), G = A w^2/g. A flight of one table period leaves at relative speed pi (units g/w) with the
# table's own speed G cos(phi) left out: pi - G cos = r (pi + G cos), so cos(phi) = pi (1-r) / ((1+r) G).
BALL_FOLD = math.pi * (1 - 0.8) / (1 + 0.8)


def ball_phase(G: float, r: float) -> float:
    """Return cos of the table's phase at landing on the period-1 orbit."""
    return math.pi * (1 - r) / ((1 + r) * G)


# Páez Chávez, Zhang, Liu (2020), figures 4.6 and 4.7 as printed.
PAPER_GR_TAU = (3.1903, 4.6563)
PAPER_GR_K = 0.1747
# The converged value of the paper's scheme (N = 15, M = 2). (shared validation table)
SCHEME_GR_K = 0.174746955


def chain_transfer(omega: float, tau: float, order: int, n: int) -> complex:
    """Return what the chain of order M and length n does to exp(i omega t): (sum_{k<=M} (i omega tau/n)^k / k!)^(-n)."""
    z = 1j * omega * tau / n
    return sum(z**k / math.factorial(k) for k in range(order + 1)) ** (-n)

"""Exact solutions and reference numbers that the tests compare with, each with its source or derivation."""

from __future__ import annotations

import math

# Wall x <= .2, v+ = -.8 v-, x'' + .1 x' + x = cos 2t, period pi. The flight is a linear oscillation with two constants,
# fixed by x = .2 at both ends and v(end) = -v(start)/.8; root of the remaining scalar equation. (shared validation
# table)
WALL = {"t_hit": 1.0849389538, "v_out": -2.4554898724}

# Bouncing ball on a table A sin(wt), G = A w^2/g. A flight of one table period leaves at relative speed pi (units g/w)
# with the table's own speed G cos(phi) left out: pi - G cos = r (pi + G cos), so cos(phi) = pi (1-r) / ((1+r) G).


def ball_phase(G: float, r: float) -> float:
    """Return cos of the table's phase at landing on the period-1 orbit."""
    return math.pi * (1 - r) / ((1 + r) * G)


# Páez Chávez, Zhang, Liu (2020), figures 4.6 and 4.7 as printed.
PAPER_GR_TAU = (3.1903, 4.6563)
PAPER_GR_K = 0.1747
# The converged value of the paper's scheme (N = 15, M = 2). (shared validation table)
SCHEME_GR_K = 0.174746955


def chain_transfer(omega: float, tau: float, order: int, n: int) -> complex:
    """Return what the chain of order M and length n does to exp(i omega t).

    It is (sum_{k<=M} (i omega tau/n)^k / k!)^(-n).
    """
    z = 1j * omega * tau / n
    return sum(z**k / math.factorial(k) for k in range(order + 1)) ** (-n)


# The impact oscillator as a delay equation, tau_d = 3.8, K = 0.12: velocity at impact (direct collocation of degree 10,
# agreeing with a prototype on three meshes).
IMPACT_SPEED = 0.734426370925


def grazing_amplitude(K: float, D: complex, omega=0.8, a=0.9, zeta=0.01) -> float:
    """Return the amplitude of the non-impacting period-1 orbit; D is what the delay does to exp(i omega t)."""
    return a * omega**2 / abs(1 - omega**2 + 1j * omega * (2 * zeta + K * (1 - D)))


# Where that orbit grazes (amplitude e = 1.26), from the closed form above. (shared validation table)
GRAZING_TAU = (4.7007576118, 6.3261672235)


def relay(a: float, tau: float) -> tuple[float, float]:
    """Return period and amplitude of x' = a x - sgn x(t - tau).

    They are arcs of exponentials from 0 to their extremum tau later.
    """
    return 2 * (tau - math.log(2 - math.exp(a * tau)) / a), (math.exp(a * tau) - 1) / a


def on_off(U: float, L: float, theta: float, tau: float) -> tuple[float, float, float]:
    """Return period, highest and lowest value of the on-off control: x runs on for tau after it passes theta."""
    high, low = U + (theta - U) * math.exp(-tau), L + (theta - L) * math.exp(-tau)
    return 2 * tau + math.log((high - L) / (theta - L)) + math.log((U - low) / (U - theta)), high, low


def neuron(drive: float, kick: float, tau: float) -> float:
    """Return the period of the neuron that kicks itself tau after each spike: the kick falls at phase tau mod T."""
    for wraps in range(100):
        # T = phi + ln((drive exp(-phi) - kick) / (drive - 1)) with phi = tau - wraps T: the right side falls.
        def miss(T: float, wraps: int = wraps) -> float:
            phi = tau - wraps * T
            return phi + math.log((drive * math.exp(-phi) - kick) / (drive - 1)) - T

        low, high = tau / (wraps + 1), tau / wraps if wraps else 100.0
        low, high = low + 1e-12, high - 1e-12
        try:
            if miss(low) * miss(high) > 0:
                continue
        except ValueError:
            pass
        for _ in range(200):
            middle = 0.5 * (low + high)
            try:
                positive = miss(middle) > 0
            except ValueError:
                positive = False
            low, high = (middle, high) if positive else (low, middle)
        phi = tau - wraps * low
        if 0 <= phi <= low and abs(miss(low)) < 1e-9:
            return low
    raise AssertionError("no period")


# Smooth equations (shared validation table; independent integrators and root finders). Wright's maximum: the table
# prints 1.9018147463, which a maximum over samples gives. At the maximum x' = 0, so x(t - 1) = 0; the method of steps
# (DOP853, rtol 3e-14) evaluated one delay after that zero gives the value below, as does collocation.
WRIGHT = {"period": 4.4027436513, "highest": 1.9018147825846923}
MACKEY_GLASS_PD = {"tau": 1.3249215258, "period": 3.9196496081}


def turning(zeta: float, W: float, j: int = 1) -> tuple[float, float]:
    """Return (w, tau) on a lobe of x'' + 2 zeta x' + x = -w (x - x(t - tau)) at chatter frequency W."""
    w = ((1 - W**2) ** 2 + 4 * zeta**2 * W**2) / (2 * (W**2 - 1))
    return w, 2 / W * (j * math.pi - math.atan((W**2 - 1) / (2 * zeta * W)))

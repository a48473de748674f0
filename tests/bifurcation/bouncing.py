"""A ball on a shaken table, apart from the program: flights in closed form to 40 digits, impacts one by one.

Height y above the table, y'' = G sin t - 1, restitution r; the ball rests while G sin t < 1.
"""

from __future__ import annotations

from mpmath import asin, cos, findroot, mpf, pi, sin, sqrt, workdps

DIGITS = 40
# Impacts slower than this are nothing.
NOTHING = mpf("1e-15")
# A flight that takes this part of the time left until the release: the next ones take smaller parts.
SMALL = mpf("0.01")


def fly(G, t, v, s):
    """Return the height s after the ball left the table at t with speed v."""
    return v * s + G * (sin(t) - sin(t + s) + s * cos(t)) - s * s / 2


def land(G, t, v, end):
    """Return how long the ball flies that leaves the table at t with speed v; None if longer than to ``end``."""
    pressed = 1 - G * sin(t)
    h = min(v / pressed / 10, mpf("0.05")) if v > 0 and pressed > 0 else mpf("0.05")
    s = h
    while fly(G, t, v, s) > 0:
        s += h
        if t + s > end:
            return None
    root = findroot(lambda x: fly(G, t, v, x), (s - h, s), solver="anderson", tol=mpf("1e-70"), verify=False)
    return root if t + root <= end else None


def follow(G, r):
    """Yield the impacts (time, speed) after the release up to the next one."""
    G, r = mpf(G), mpf(r)
    t, v = asin(1 / G), mpf(0)
    end = t + 2 * pi
    while (s := land(G, t, v, end)) is not None:
        came = G * (cos(t + s) - cos(t)) + s - v
        t, v = t + s, r * came
        yield t, came


def list_impacts(G, r):
    """Return the impacts (time, speed) until they are nothing, and when they accumulate."""
    with workdps(DIGITS):
        found = []
        for t, came in follow(G, r):
            found.append((float(t), float(came)))
            if came < NOTHING:
                break
        return found, found[-1][0]


def comes_to_rest(G, r):
    """Return whether the impacts accumulate before the next release."""
    G = mpf(G)
    end, jerk = asin(1 / G) + 2 * pi, sqrt(G * G - 1)
    return any(mpf(r) * came < SMALL * jerk * (end - t) ** 2 for t, came in follow(G, r))


def find_last_rest(r, low, high):
    """Return the largest G between two at which the ball comes to rest."""
    with workdps(DIGITS):
        low, high = mpf(low), mpf(high)
        for _ in range(48):
            middle = (low + high) / 2
            low, high = (middle, high) if comes_to_rest(middle, r) else (low, middle)
        return float(low)

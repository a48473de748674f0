"""Models that read their past by lags that vary, as rates and as integrals, with what is known of their motions."""

from __future__ import annotations

import math

import numpy as np

from tests.simulate.motions import trajectory_of


def write_model(states, rates, history, parameters="{k: 1}", period=None):
    """Return the text of a model without events."""
    lines = ["name: m", f"states: [{', '.join(states)}]", f"parameters: {parameters}"]
    lines += [f"forcing: {{period: {period}}}"] if period else []
    lines += ["modes:", "  m:", *(f'    {s}\': "{rate}"' for s, rate in zip(states, rates, strict=True))]
    lines += ["initial:", *(f'  {s}: "{past}"' for s, past in zip(states, history, strict=True))]
    return "\n".join([*lines, ""])


def decay(rate):
    """Return the text of a model whose motion is exp(-t) if ``rate`` is -x along it."""
    return write_model(["x"], [rate], ["exp(-t)"])


def circle(rate):
    """Return the text of a model whose motion is (cos t, -sin t) if ``rate`` is -x along it."""
    return write_model(["x", "y"], ["y", rate], ["cos(t)", "-sin(t)"])


def shift(lag, *, rate=False):
    """Return x(t - lag), or y'(t - lag), in terms of x and y on the circle."""
    sign = "-" if rate else ""
    return f"({sign}x*cos({lag}) - ({sign}y)*sin({lag}))"


def measure_errors(text, method, finer):
    """Return step lengths, and the largest errors of a motion on the circle with steps no longer than them.

    Tolerances allow everything. Steps are cut where jumps come back, so that errors fall unevenly: many are taken.
    """
    h, times, errors = 12.0 / (finer * np.arange(15, 40, 2)), np.linspace(0.0, 12.0, 400), []
    for longest in h:
        trajectory = trajectory_of(text, 12.0, method(rtol=1e8, atol=1e8, max_step=longest))
        errors.append(np.max(np.abs(trajectory(times) - np.stack([np.cos(times), -np.sin(times)], axis=-1))))
    return h, errors


# y'(t) = y(y(t)) from y(2) = 1, with y = 1/2 before: Feldstein and Neves, SIAM J. Numer. Anal. 21 (1984); here t
# begins at 0, and c is the time.
FELDSTEIN_NEVES = write_model(["x", "c"], ["x(t - (c + 2 - x))", "1"], ["0.5", "0"])
FELDSTEIN_NEVES_START = [1.0, 0.0]


def feldstein_neves(t):
    """Return the solution of :data:`FELDSTEIN_NEVES`; with y' = y / 2 and y' = 2 exp(y / 2 - 2) from piece to piece."""
    u = t + 2.0
    if u <= 4.0:
        return u / 2.0
    if u <= 4.0 + 2.0 * math.log(2.0):
        return 2.0 * math.exp(u / 2.0 - 2.0)
    return 4.0 - 2.0 * math.log(5.0 + 2.0 * math.log(2.0) - u)

"""How errors of the integrator fall with the step: an oscillator, and one that bounces and is read later."""

from __future__ import annotations

import math

import numpy as np

from tests.simulate.motions import trajectory_of

# Tolerances so large that every step is as long as it may be: half the forcing period.
FIXED = 1e8


# With tolerances that allow everything, steps are as long as a forcing period p allows: p/2.
OSCILLATOR = (
    "name: o\nstates: [x, v]\nparameters: {p: 1}\nforcing: {period: p}\nmodes: {m: {x': v, v': -x}}\ninitial: {x: 1}\n"
)


# x = |sin t| bounces at every multiple of pi; y hears of it pi/2 later. Breaking points are the multiples of pi/2.
BOUNCER = (
    "name: b\nstates: [x, v, y]\nparameters: {p: 1}\nforcing: {period: p}\nmodes: {m: {x': v, v': -x, y': x(t - pi/2) "
    "- y}}\n"
    "events: {hit: x}\nresets: {turn: {v: -v}}\n"
    "segments: {s: {mode: m, event: hit, direction: falling, reset: turn, to: m}}\ninitial: {v: 1}\n"
)


def oscillator_error(method, h=1.0):
    """Return the error of x'' = -x at t = 12."""
    trajectory = trajectory_of(OSCILLATOR, 12.0, method, p=2 * h)
    return float(np.linalg.norm(trajectory(12.0) - [math.cos(12), -math.sin(12)]))


def bouncer_errors(method, h=10.0):
    """Return the errors of y(4.5 pi) and of the times of bounces; y = int_0^(4 pi) exp(u - 4 pi) abs(sin u) du."""
    trajectory = trajectory_of(BOUNCER, 4.5 * math.pi, method, p=2 * h)
    y = sum(math.exp(k * math.pi) for k in range(4)) * (math.exp(math.pi) + 1) / 2 * math.exp(-4 * math.pi)
    assert len(trajectory.events) == 4
    return abs(trajectory(4.5 * math.pi)[2] - y), float(np.max(np.abs(trajectory.events.t - math.pi * np.arange(1, 5))))


def measure_order(h, errors):
    """Return the power of h with which errors fall."""
    assert min(errors) > 1e-13, "rounding hides the order"
    return np.polyfit(np.log(h), np.log(errors), 1)[0]

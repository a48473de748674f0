"""Of very many random events none is lost and none invented: every arc is compared with the exact solution.

``make stress`` does so with a million events; the tests of every day with some twenty thousand.
"""

from __future__ import annotations

import numpy as np
import pytest

from pddecont.delay import Direct
from pddecont.errors import ConvergenceError
from pddecont.simulate import Method, Simulator, record_trajectory
from tests.conftest import numeric_from
from tests.simulate.exact_switching import LinearMode, find_wrong_side

METHOD = Method(1e-11, 1e-13)
# How far from zero an exact event function may be where the integration finds it on zero: some local errors.
MARGIN, FARTHEST = 1e-8, 20.0
SURFACES = ("e1", "e2", "e3")
DIRECTIONS = {"rising": 1, "falling": -1, "any": 0}


class Run:
    """The arcs between the events of a motion, with the segment that begins and ends each."""

    def __init__(self, numeric, p, t_end, initial):
        simulator = Simulator(numeric, Direct(), METHOD)
        state = simulator.start(simulator.values(p), initial)
        events = record_trajectory(simulator, p, state, t_end).events
        self.segments = numeric.model.segments
        # A motion that runs away is looked at as long as MARGIN is above its errors.
        far = np.max(np.abs(events.before), axis=1) > FARTHEST
        n = int(np.argmax(far)) if far.any() else len(events)
        names = np.array(events.segment[:n])
        self.begun, self.ended = names[:-1], names[1:]
        self.start, self.end = events.after[: n - 1], events.before[1:n]
        self.length = np.diff(events.t[:n])
        self.mode = np.array([self.segments[name].to for name in self.begun])
        self.n_events = n

    def check_modes(self):
        assert all(self.segments[name].mode == mode for name, mode in zip(self.ended, self.mode, strict=True))


def check_function(run, rows, functions, event, directions):
    """Check one event function on the arcs ``rows`` of one mode, whose segments end where it crosses in ``directions``.

    It is zero where the event ends the arc and crosses there in a direction that counts; it crosses in none before.
    Where it starts on zero, after its own event, the flow says on which side it is.
    """
    lengths = run.length[rows]
    begins = np.array([run.segments[name].event == event for name in run.begun[rows]], dtype=bool)
    ends = np.array([run.segments[name].event == event for name in run.ended[rows]], dtype=bool)
    zero = np.zeros(len(rows))
    start, slope = functions.value(zero), functions.slope(zero)
    on_zero = begins & (np.abs(start) < MARGIN)
    assert np.all(np.abs(functions.value(lengths)[ends]) < MARGIN), event
    # A second crossing so soon that the value says nothing: the mean slope on the way back is none.
    soon = on_zero & ends
    mean = np.abs(functions.value(lengths) - start)[soon] / np.maximum(lengths[soon], 1e-300)
    assert np.all(mean <= 1e-3 * np.abs(slope[soon]) + MARGIN / lengths[soon].clip(1e-3)), event
    at_end = np.sign(functions.slope(lengths))
    for direction in (1, -1):
        if not {0, direction} & directions:
            continue
        # No crossing in this direction inside: once the function is on the side it comes from, it stays there.
        side = np.where(on_zero, np.sign(slope), np.sign(start))
        from_there = side == -direction
        wrong = find_wrong_side(
            functions.take(from_there), side[from_there], lengths[from_there], MARGIN, on_zero[from_there]
        )
        assert not wrong.any(), (event, run.begun[rows][from_there][wrong], lengths[from_there][wrong])
    clear = ends & (np.abs(functions.slope(lengths)) > 1e-4) & (lengths > 1e-6)
    assert all(0 in directions or d in directions for d in at_end[clear]), event


# Random linear modes and surfaces. --------------------------------------------------------------------------------
def write_random_model(rng):
    """Return a model of two linear modes with three surfaces, and resets that map the plane."""
    lines = ["name: random", "states: [x, y]", "parameters:"]
    names = [f"{m}{k}" for m in "pq" for k in ("xx", "xy", "yx", "yy", "x", "y")]
    names += [f"{e}{k}" for e in SURFACES for k in "xyd"] + [f"g{k}" for k in ("xx", "xy", "yx", "yy", "x", "y")]
    lines += [f"  {name}: 1" for name in names]
    lines += ["modes:"]
    lines += [f"  {m}: {{x': {m}xx*x + {m}xy*y + {m}x, y': {m}yx*x + {m}yy*y + {m}y}}" for m in "pq"]
    lines += ["events:", *(f"  {e}: {e}x*x + {e}y*y - {e}d" for e in SURFACES)]
    lines += ["resets: {map: {x: gxx*x + gxy*y + gx, y: gyx*x + gyy*y + gy}}", "segments:"]
    for mode in "pq":
        for event in SURFACES:
            direction = rng.choice(list(DIRECTIONS))
            reset = "reset: map, " if event == "e1" else ""
            to = rng.choice(["p", "q"]) if event != "e2" else {"p": "q", "q": "p"}[mode]
            lines.append(f"  {mode}_{event}: {{mode: {mode}, event: {event}, direction: {direction}, {reset}to: {to}}}")
    return "\n".join([*lines, "initial: {mode: p}"]) + "\n"


def draw_spiral(rng):
    """Return a matrix with eigenvalues -damping +- i frequency in random coordinates, and a centre near the origin."""
    frequency, damping = rng.uniform(0.5, 5.0), rng.uniform(-0.02, 0.1)
    turn = np.array([[-damping, frequency], [-frequency, -damping]])
    skew = np.eye(2) + rng.uniform(-0.4, 0.4, (2, 2))
    A = skew @ turn @ np.linalg.inv(skew)
    return A, -A @ rng.uniform(-0.5, 0.5, 2)


def follow_random_motion(rng, t_end):
    """Return the arcs of a random motion, its linear modes and surfaces; None where it slides, rests or runs away."""
    numeric = numeric_from(write_random_model(rng))
    modes = {m: LinearMode(*draw_spiral(rng)) for m in "pq"}
    surfaces = {e: (rng.normal(size=2), rng.uniform(-0.4, 0.4)) for e in SURFACES}
    angle, far = rng.uniform(0, 2 * np.pi), rng.uniform(0.6, 1.0)
    turn = far * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    p = np.concatenate(
        [np.concatenate([mode.A.ravel(), mode.b]) for mode in modes.values()]
        + [[*row, constant] for row, constant in surfaces.values()]
        + [turn.ravel(), rng.uniform(-1, 1, 2)]
    )
    try:
        return Run(numeric, p, t_end, rng.uniform(-1, 1, 2)), modes, surfaces
    except ConvergenceError:
        return None


def check_random_motions(seed, n_events):
    rng, n = np.random.default_rng(seed), 0
    while n < n_events:
        motion = follow_random_motion(rng, 300.0)
        if motion is None or motion[0].n_events < 20:
            continue
        run, modes, surfaces = motion
        run.check_modes()
        for name, mode in modes.items():
            rows = np.flatnonzero(run.mode == name)
            for event, (row, constant) in surfaces.items():
                directions = {
                    DIRECTIONS[s.direction] for s in run.segments.values() if (s.mode, s.event) == (name, event)
                }
                check_function(run, rows, mode.follow(run.start[rows], row, 0.0, -constant), event, directions)
            exact = [mode.follow(run.start[rows], np.eye(2)[k]).value(run.length[rows]) for k in (0, 1)]
            assert np.allclose(np.transpose(exact), run.end[rows], rtol=0, atol=MARGIN)
        n += run.n_events
    return n


# Two comparators that switch a converter under a triangular ramp. ----------------------------------------------------
def write_converter():
    """Return a converter whose mode says of each comparator on which side it is, and whether the ramp rises."""
    lines = ["name: converter", "states: [v, i, r]"]
    lines.append("parameters: {R: 1, C: 1, L: 1, E: 1, F: 1, up: 1, down: 1, g1: 1, g2: 1, k: 1}")
    lines.append("definitions: {charge: (i - v/R)/C}")
    lines.append("modes:")
    ways = [(a, b, w) for a in (0, 1) for b in (0, 1) for w in ("u", "d")]
    for a, b, w in ways:
        rate = "up" if w == "u" else "-down"
        lines.append(f"  m{a}{b}{w}: {{v': charge, i': ({1 - a}*E + {1 - b}*F - v)/L, r': {rate}}}")
    lines.append("events: {c1: v - g1 - k*r, c2: v - g2 - k*r, top: r - 1, bottom: r}")
    lines.append("segments:")
    for a, b, w in ways:
        mode = f"m{a}{b}{w}"
        for event, bit, to in (("c1", a, f"m{1 - a}{b}{w}"), ("c2", b, f"m{a}{1 - b}{w}")):
            direction = "falling" if bit else "rising"
            lines.append(f"  {mode}_{event}: {{mode: {mode}, event: {event}, direction: {direction}, to: {to}}}")
        edge, direction, other = ("top", "rising", "d") if w == "u" else ("bottom", "falling", "u")
        lines.append(f"  {mode}_{edge}: {{mode: {mode}, event: {edge}, direction: {direction}, to: m{a}{b}{other}}}")
    return "\n".join([*lines, "initial: {mode: m00u, r: 0}"]) + "\n"


def check_converters(seed, n_events):
    """The comparators' thresholds lie 1e-3 to nothing apart, so that their edges come at nearly one time."""
    rng, n = np.random.default_rng(seed), 0
    numeric = numeric_from(write_converter())
    while n < n_events:
        R, C, L, E, F = rng.uniform([0.5, 1, 1, 10, 1], [2, 4, 4, 30, 10])
        up, down = 1 / rng.uniform(0.5, 1.0), 1 / rng.choice([1e-3, 0.3])
        k, apart = rng.uniform(0.3, 2.0), rng.choice([0.0, 1e-16, 1e-14, 1e-12, 1e-9, 1e-6, 1e-3])
        g1 = rng.uniform(0.4, 0.8) * E
        p = np.array([R, C, L, E, F, up, down, g1, g1 + apart, k])
        run = Run(numeric, p, 300.0, [0.0, 0.0, 0.0])
        run.check_modes()
        A = np.array([[-1 / (R * C), 1 / C], [-1 / L, 0.0]])
        for name in sorted(set(run.mode)):
            rows = np.flatnonzero(run.mode == name)
            a, b, w = int(name[1]), int(name[2]), name[3]
            mode = LinearMode(A, np.array([0.0, ((1 - a) * E + (1 - b) * F) / L]), up if w == "u" else -down)
            start, lengths = run.start[rows], run.length[rows]
            v, zero = np.array([1.0, 0.0]), np.zeros(2)
            for event, bit, g in (("c1", a, g1), ("c2", b, g1 + apart)):
                functions = mode.follow(start, v, -k, -g)
                side = np.full(len(rows), 1 if bit else -1)
                begins = np.array([segment.endswith(event) for segment in run.begun[rows]], dtype=bool)
                wrong = find_wrong_side(functions, side, lengths, MARGIN, begins)
                assert not wrong.any(), (p, event, lengths[wrong])
                check_function(run, rows, functions, event, {-1 if bit else 1})
            edge, constant = ("top", -1.0) if w == "u" else ("bottom", 0.0)
            check_function(run, rows, mode.follow(start, zero, 1.0, constant), edge, {1 if w == "u" else -1})
        n += run.n_events
    return n


def test_random_linear_motions_lose_and_invent_no_event():
    assert check_random_motions(1, 10_000) >= 10_000


def test_comparators_with_edges_at_nearly_one_time_lose_and_invent_no_event():
    assert check_converters(2, 10_000) >= 10_000


@pytest.mark.slow
def test_a_million_random_events_are_neither_lost_nor_invented():
    assert check_random_motions(3, 500_000) + check_converters(4, 500_000) >= 1_000_000
